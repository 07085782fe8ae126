"""Tasks behind gymnasium's interface: five values, seeds that repeat, options, a life of its own."""

from __future__ import annotations

import pickle
from contextlib import closing

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence

from rlbench_pin.environment import (
    ArmActionMode,
    Discrete,
    EndEffectorVelocity,
    GripperJointPosition,
    JointPosition,
    JointVelocity,
    MoveArmThenGripper,
    SafeArm,
)
from rlbench_pin.errors import EnvironmentClosed
from rlbench_pin.gym import GymnasiumEnv
from rlbench_pin.robot import UnknownRobot
from rlbench_pin.tasks import task_class
from tests.gym.support import episode


@pytest.mark.simulation
def test_same_seed_same_episode(reach: GymnasiumEnv) -> None:
    """A seed brings the same episode back, and unseeded episodes after it come in the same order."""
    first = [episode(reach, 5), episode(reach, None), episode(reach, None)]
    again = [episode(reach, 5), episode(reach, None), episode(reach, None)]
    assert data_equivalence(first, again, exact=True)
    assert not data_equivalence(first[1][0], first[2][0])


def test_the_seed_is_that_of_the_task_environment(reach: GymnasiumEnv) -> None:
    """`reset(seed=7)` starts the very episode that seed 7 starts elsewhere."""
    obs, _ = reach.reset(seed=7)
    _, plain = reach.task_environment.reset(seed=7)
    assert plain.task_low_dim_state is not None
    np.testing.assert_array_equal(obs["task_low_dim_state"], plain.task_low_dim_state.astype(np.float32))


@pytest.mark.simulation
def test_two_environments_do_not_disturb_each_other() -> None:
    """Stepping one environment changes nothing in another of the same process, even of one action mode object."""
    mode = MoveArmThenGripper(JointVelocity(), GripperJointPosition())
    with GymnasiumEnv("open_drawer", action_mode=mode) as a, GymnasiumEnv("open_drawer", action_mode=mode) as b:
        assert a.task_environment.action_mode is not b.task_environment.action_mode
        alone = episode(a, 2)
        rng = np.random.default_rng(0)
        low, high = a.action_space.low, a.action_space.high
        mixed = [a.reset(seed=2)]
        b.reset(seed=9)
        for _ in range(5):
            mixed.append(a.step(rng.uniform(low, high).astype(np.float32)))
            b.step(b.action_space.sample())
        assert data_equivalence(alone, mixed, exact=True)


@pytest.mark.simulation
def test_variation_option_holds_for_one_episode(reach: GymnasiumEnv) -> None:
    """A variation in the options is played once; -1 draws one from the seed."""
    assert reach.reset(seed=0, options={"variation": 4})[1]["variation"] == 4
    assert reach.reset(seed=0)[1]["variation"] == 0
    drawn = {reach.reset(seed=seed, options={"variation": -1})[1]["variation"] for seed in range(4)}
    assert len(drawn) > 1


@pytest.mark.simulation
def test_factors_are_those_of_the_arguments_or_of_the_options() -> None:
    """`info` says which; an option counts for the episodes after it, too, and the instruction is the one of the factor."""
    with closing(GymnasiumEnv("open_drawer", factors="instruction_none:1")) as env:
        assert env.reset(seed=0)[1]["text_descriptions"] == [""]
        assert env.reset(seed=0)[1]["factors"] == "instruction_none:1"
        for options in ({"factors": "friction:2"}, None):
            info = env.reset(seed=0, options=options)[1]
            assert info["factors"] == "friction:2"
            assert info["text_descriptions"] != [""]
        assert env.reset(seed=0, options={"factors": ""})[1]["factors"] == ""


def test_reset_to_demo_starts_as_the_demo_and_its_actions_succeed() -> None:
    """From the start of a demonstration its joint positions reach the goal: reward 1, success, the end."""
    with GymnasiumEnv("reach_target", action_mode=MoveArmThenGripper(JointPosition(), Discrete())) as env:
        demo = env.task_environment.get_demos(1, live_demos=True, seed=11)[0]
        env.reset(seed=1)
        obs, info = env.reset(options={"reset_to_demo": demo})
        assert not info["success"]
        np.testing.assert_array_equal(obs["joint_positions"], demo[0].joint_positions.astype(np.float32))
        for frame in list(demo)[1:]:
            action = np.append(frame.joint_positions, frame.gripper_open)
            _, reward, terminated, _, info = env.step(action)
            if terminated:
                break
        assert (reward, terminated, info["success"], info["is_success"]) == (1.0, True, True, True)


def test_a_time_limit_truncates() -> None:
    """`max_episode_steps` ends an episode without terminating it."""
    env = gymnasium.make("rlbench_pin/open_drawer-state-v0", max_episode_steps=3)
    env.reset(seed=0)
    ends = [env.step(np.zeros(8, dtype=np.float32))[2:4] for _ in range(3)]
    env.close()
    assert ends == [(False, False), (False, False), (False, True)]


def test_shaped_reward_is_the_tasks_own() -> None:
    """With shaped rewards, reach_target pays minus the distance between tip and ball."""
    with GymnasiumEnv("reach_target", shaped_rewards=True) as env:
        env.reset(seed=0)
        obs, reward, *_ = env.step(np.append(np.full(7, 0.02), 0.04).astype(np.float32))
        assert reward == pytest.approx(-np.linalg.norm(obs["gripper_pose"][:3] - obs["task_low_dim_state"]), abs=1e-5)


@pytest.mark.simulation
@pytest.mark.parametrize("arm", [EndEffectorVelocity(), SafeArm(JointVelocity())], ids=["solver", "filter"])
def test_a_mode_that_has_run_elsewhere_is_taken(arm: ArmActionMode) -> None:
    """An action mode holds settings only, so that one which has run can be given to another environment."""
    mode = MoveArmThenGripper(arm, Discrete())
    with GymnasiumEnv("reach_target", action_mode=mode) as env:
        first = episode(env, 3)
        with GymnasiumEnv("reach_target", action_mode=env.task_environment.action_mode) as other:
            assert data_equivalence(first, episode(other, 3), exact=True)


def test_close_may_be_repeated_and_ends_everything() -> None:
    """Closing twice is fine; a closed environment says so."""
    env = GymnasiumEnv(task_class("reach_target"))
    env.reset(seed=0)
    env.close()
    env.close()
    with pytest.raises(EnvironmentClosed):
        env.reset()


@pytest.mark.simulation
def test_a_pickled_environment_is_built_anew() -> None:
    """Pickling carries the arguments, so that another process can build the same environment."""
    mode = MoveArmThenGripper(EndEffectorVelocity(), Discrete())
    with GymnasiumEnv("reach_target", action_mode=mode, variation=3) as env:
        before = episode(env, 4)
        with pickle.loads(pickle.dumps(env)) as copy:
            assert data_equivalence(before, episode(copy, 4), exact=True)


@pytest.mark.simulation
def test_another_arm_is_a_keyword() -> None:
    """Six joints and the fingers in actions; an unknown arm is refused."""
    with closing(gymnasium.make("rlbench_pin/reach_target-state-v0", robot="ur5e")) as environment:
        assert environment.action_space.shape == (7,)
        observation, _ = environment.reset(seed=0)
        assert observation["joint_positions"].shape == (6,)
        environment.step(environment.action_space.sample())
    with pytest.raises(UnknownRobot, match="ur5e"):
        gymnasium.make("rlbench_pin/reach_target-state-v0", robot="sawyer")
