"""Tasks behind gymnasium's interface: five values, spaces that hold, seeds that repeat, options, refused actions."""

from __future__ import annotations

import pickle
import subprocess
import sys
import warnings
from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env, data_equivalence

import rlbench_pin
from rlbench_pin.environment import (
    Discrete,
    EndEffectorPoseViaIK,
    EndEffectorPoseViaPlanning,
    EndEffectorVelocity,
    ERJointViaIK,
    GripperJointPosition,
    JointPosition,
    JointTorque,
    JointVelocity,
    MoveArmThenGripper,
)
from rlbench_pin.errors import EnvironmentClosed, InvalidActionError, TaskEnvironmentError, UnknownName
from rlbench_pin.gym.environment import GymnasiumEnv
from rlbench_pin.gym.ids import MAX_EPISODE_STEPS, MODES, gym_id
from rlbench_pin.tasks import task_class, task_names

IDS = [gym_id(task, mode) for task in task_names() for mode in MODES]
FEW = ("reach_target", "open_drawer", "stack_blocks")
OUT_OF_REACH = np.array([0.7, 0.6, 1.7, 0.0, 0.0, 0.0, 1.0, 1.0])
ARMS = (
    JointVelocity(),
    JointPosition(),
    JointPosition(absolute_mode=False),
    JointTorque(),
    EndEffectorVelocity(),
    EndEffectorPoseViaIK(),
    EndEffectorPoseViaPlanning(absolute_mode=False),
    ERJointViaIK(),
)


@pytest.fixture(scope="module")
def reach() -> Iterator[GymnasiumEnv]:
    """reach_target with joint differences."""
    env = GymnasiumEnv("reach_target")
    yield env
    env.close()


@pytest.fixture(scope="module")
def reach_poses() -> Iterator[GymnasiumEnv]:
    """reach_target with planned tip poses."""
    env = GymnasiumEnv("reach_target", action_mode=MoveArmThenGripper(EndEffectorPoseViaPlanning(), Discrete()))
    yield env
    env.close()


# Ids ------------------------------------------------------------------------------------------------------------------


def test_every_task_has_both_ids() -> None:
    """Each task of the library is registered for states and for pictures, with a limit of steps."""
    assert [i for i in IDS if i not in gymnasium.registry] == []
    ours = {i for i in gymnasium.registry if i.startswith("rlbench_pin/")}
    assert ours == set(IDS)
    assert {gymnasium.registry[i].max_episode_steps for i in IDS} == {MAX_EPISODE_STEPS}


@pytest.mark.parametrize("order", ["rlbench_pin, gymnasium", "gymnasium, rlbench_pin"])
def test_ids_appear_in_either_order_of_import_without_loading_tasks(order: str) -> None:
    """The ids are known whichever package comes first; neither a task nor a simulator is loaded for them."""
    code = (
        f"import {order}, sys; ids = [i for i in gymnasium.registry if i.startswith('rlbench_pin/')];"
        "heavy = [m for m in ('pybullet', 'pinocchio', 'rlbench_pin.tasks') if m in sys.modules];"
        "print(len(ids), heavy, type(gymnasium.__spec__.loader).__name__)"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert result.stdout.split("\n")[0] == f"{len(IDS)} [] SourceFileLoader", result.stderr
    assert result.stderr == ""


def test_an_unknown_id_proposes_the_nearest() -> None:
    """A misspelt id fails with gymnasium's own proposal."""
    with pytest.raises(gymnasium.error.NameNotFound, match="reach_target-state"):
        gymnasium.make("rlbench_pin/reach_targt-state-v0")


# The checker ----------------------------------------------------------------------------------------------------------


def checked(name: str) -> list[str]:
    """Run gymnasium's checker over an id and return its warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        env = gymnasium.make(name).unwrapped
        check_env(env)
        env.close()
    return [str(w.message) for w in caught if "coal" not in str(w.message)]


@pytest.mark.parametrize("task", FEW)
def test_checker_has_nothing_to_say(task: str) -> None:
    """Gymnasium's checker passes without a warning."""
    assert checked(gym_id(task, "state")) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", IDS)
def test_checker_has_nothing_to_say_of_any_id(name: str) -> None:
    """Gymnasium's checker passes without a warning for every task, with and without pictures."""
    assert checked(name) == []


# Spaces ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "arm", ARMS, ids=lambda arm: f"{type(arm).__name__}{'' if getattr(arm, 'absolute_mode', 1) else '-delta'}"
)
def test_random_actions_of_every_mode_stay_in_the_spaces(arm: Any) -> None:
    """Bounds are finite in every action mode, random actions are taken, and observations lie in their space."""
    with GymnasiumEnv("open_drawer", action_mode=MoveArmThenGripper(arm, GripperJointPosition())) as env:
        assert np.isfinite(env.action_space.low).all() and np.isfinite(env.action_space.high).all()
        env.action_space.seed(1)
        obs, _ = env.reset(seed=1)
        for _ in range(8):
            assert obs in env.observation_space
            obs, reward, terminated, truncated, info = env.step(env.action_space.sample())
            assert (type(reward), type(terminated), truncated) == (float, bool, False)
            assert info["success"] is info["is_success"]
        assert obs in env.observation_space


def test_observations_carry_what_the_interface_promises(reach: GymnasiumEnv) -> None:
    """The state has the eight named boxes in float32, and each row says where the ball is."""
    obs, info = reach.reset(seed=3)
    shapes = {name: value.shape for name, value in obs.items()}
    assert shapes == {
        "joint_velocities": (7,),
        "joint_positions": (7,),
        "joint_forces": (7,),
        "gripper_open": (1,),
        "gripper_pose": (7,),
        "gripper_joint_positions": (2,),
        "gripper_touch_forces": (6,),
        "task_low_dim_state": (3,),
    }
    assert {value.dtype for value in obs.values()} == {np.dtype(np.float32)}
    ball = reach.task_environment.world.body("target").pose[:3]
    np.testing.assert_allclose(obs["task_low_dim_state"], ball, atol=1e-6)
    assert info["text_descriptions"] == reach.task_environment.get_task_descriptions()


def test_vision_adds_four_pictures() -> None:
    """Vision observations hold four pictures of the asked size, and the pictures show something."""
    with GymnasiumEnv("reach_target", "vision", image_size=(48, 32)) as env:
        obs, _ = env.reset(seed=0)
        assert obs in env.observation_space
        for camera in ("left_shoulder", "right_shoulder", "wrist", "front"):
            assert obs[f"{camera}_rgb"].shape == (32, 48, 3)
            assert obs[f"{camera}_rgb"].std() > 5.0


@pytest.mark.slow
@pytest.mark.parametrize("task", task_names())
def test_task_state_has_one_length(task: str) -> None:
    """No variation has a longer or shorter task state than the space says, so nothing is filled up."""
    with GymnasiumEnv(task) as env:
        size = env.observation_space["task_low_dim_state"].shape[0]
        count = env.task_environment.variation_count()
        for variation in np.unique(np.linspace(0, count - 1, min(count, 4)).round().astype(int)):
            env.reset(seed=0, options={"variation": variation})
            assert len(env.task_environment.task.get_low_dim_state()) == size


# Episodes -------------------------------------------------------------------------------------------------------------


def episode(env: gymnasium.Env[Any, Any], seed: int | None, steps: int = 5) -> list[Any]:
    """Return everything that an episode of fixed actions yields."""
    rng = np.random.default_rng(0)
    low, high = env.action_space.low, env.action_space.high  # type: ignore[attr-defined]
    return [env.reset(seed=seed), *(env.step(rng.uniform(low, high).astype(np.float32)) for _ in range(steps))]


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


def test_variation_option_holds_for_one_episode(reach: GymnasiumEnv) -> None:
    """A variation in the options is played once; -1 draws one from the seed."""
    assert reach.reset(seed=0, options={"variation": 4})[1]["variation"] == 4
    assert reach.reset(seed=0)[1]["variation"] == 0
    drawn = {reach.reset(seed=seed, options={"variation": -1})[1]["variation"] for seed in range(4)}
    assert len(drawn) > 1


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


# Refused actions ------------------------------------------------------------------------------------------------------


def test_a_refused_pose_is_reported_and_changes_nothing(reach_poses: GymnasiumEnv) -> None:
    """A pose out of reach gives reward 0, the same observation and the reason, and the episode goes on."""
    before, _ = reach_poses.reset(seed=0)
    after, reward, terminated, truncated, info = reach_poses.step(OUT_OF_REACH)
    assert (reward, terminated, truncated, info["success"]) == (0.0, False, False, False)
    assert "pose" in info["error"]
    assert data_equivalence(before, after, exact=True)


def test_a_refused_pose_may_end_the_episode_or_be_raised() -> None:
    """The other two ways of handling a refused action."""
    mode = MoveArmThenGripper(EndEffectorPoseViaPlanning(), Discrete())
    with GymnasiumEnv("reach_target", action_mode=mode, invalid_action="terminate") as env:
        env.reset(seed=0)
        assert env.step(OUT_OF_REACH)[1:3] == (0.0, True)
    with GymnasiumEnv("reach_target", action_mode=mode, invalid_action="raise") as env:
        env.reset(seed=0)
        with pytest.raises(InvalidActionError, match="pose"):
            env.step(OUT_OF_REACH)


def test_quaternions_are_brought_to_unit_length(reach_poses: GymnasiumEnv) -> None:
    """A policy over a box may name a rotation by four numbers of any length."""
    obs, _ = reach_poses.reset(seed=0)
    pose = obs["gripper_pose"].astype(np.float64)
    pose[2] -= 0.05
    pose[3:] *= 0.4
    obs, *_, info = reach_poses.step(np.append(pose, 1.0))
    assert "error" not in info
    np.testing.assert_allclose(obs["gripper_pose"][:3], pose[:3], atol=0.01)


# Bad input ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("action", [np.zeros(7), np.zeros((1, 8)), np.full(8, np.nan), [np.inf] * 8])
def test_malformed_actions_are_the_callers_mistake(reach: GymnasiumEnv, action: Any) -> None:
    """Wrong shapes, NaN and infinity are raised, not swallowed, and the message names the numbers."""
    reach.reset(seed=0)
    with pytest.raises(InvalidActionError, match="8 finite numbers.*finger"):
        reach.step(action)


@pytest.mark.parametrize(
    ("options", "error", "says"),
    [
        ({"variaton": 1}, UnknownName, "Did you mean 'variation'"),
        ({"variation": 99}, TaskEnvironmentError, "has no variation 99"),
        ({"variation": -2}, TaskEnvironmentError, "has no variation -2"),
        ({"variation": "red"}, TaskEnvironmentError, "whole number"),
        ({"variation": True}, TaskEnvironmentError, "whole number"),
        ({"reset_to_demo": [1, 2]}, TaskEnvironmentError, "not list"),
        ({"reset_to_demo": rlbench_pin.Demo([], random_seed=0, task_name="open_drawer")}, TaskEnvironmentError, "open_drawer"),
        ({"reset_to_demo": rlbench_pin.Demo([], random_seed=0), "variation": 1}, TaskEnvironmentError, "not both"),
    ],
)
def test_bad_reset_options_are_typed_errors(
    reach: GymnasiumEnv, options: dict[str, Any], error: type[Exception], says: str
) -> None:
    """Unknown options, variations that do not exist, and what is no demonstration of this task."""
    with pytest.raises(error, match=says):
        reach.reset(seed=0, options=options)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"task": "reach_targt"}, "Did you mean 'reach_target'"),
        ({"task": "reach_target", "observation_mode": "visions"}, "Did you mean 'vision'"),
        ({"task": "reach_target", "render_mode": "rgb"}, "render mode"),
        ({"task": "reach_target", "invalid_action": "ignore"}, "invalid actions"),
        ({"task": "reach_target", "renderer": "gpu"}, "renderer"),
    ],
)
def test_bad_arguments_are_typed_errors(arguments: dict[str, Any], says: str) -> None:
    """Misspelt tasks and choices name the nearest."""
    with pytest.raises(UnknownName, match=says):
        GymnasiumEnv(**arguments)


def test_a_mode_that_has_run_elsewhere_is_taken() -> None:
    """An action mode holds settings only, so that one which has run can be given to another environment."""
    mode = MoveArmThenGripper(EndEffectorVelocity(), Discrete())
    with GymnasiumEnv("reach_target", action_mode=mode) as env:
        first = episode(env, 3)
        with GymnasiumEnv("reach_target", action_mode=env.task_environment.action_mode) as other:
            assert data_equivalence(first, episode(other, 3), exact=True)


def test_a_mode_that_cannot_be_copied_is_refused() -> None:
    """A mode of one's own that holds what cannot be copied, such as a solver of C++; the message asks for a new mode."""

    class Own(JointVelocity):
        def __deepcopy__(self, memo: dict[int, Any]) -> Any:
            raise RuntimeError("no copies")

    with pytest.raises(TaskEnvironmentError, match="no copies. Pass a new one"):
        GymnasiumEnv("reach_target", action_mode=MoveArmThenGripper(Own(), Discrete()))


# Life -----------------------------------------------------------------------------------------------------------------


def test_close_may_be_repeated_and_ends_everything() -> None:
    """Closing twice is fine; a closed environment says so."""
    env = GymnasiumEnv(task_class("reach_target"))
    env.reset(seed=0)
    env.close()
    env.close()
    with pytest.raises(EnvironmentClosed):
        env.reset()


def test_a_pickled_environment_is_built_anew() -> None:
    """Pickling carries the arguments, so that another process can build the same environment."""
    mode = MoveArmThenGripper(EndEffectorVelocity(), Discrete())
    with GymnasiumEnv("reach_target", action_mode=mode, variation=3) as env:
        before = episode(env, 4)
        with pickle.loads(pickle.dumps(env)) as copy:
            assert data_equivalence(before, episode(copy, 4), exact=True)
