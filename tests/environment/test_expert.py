"""The planner's action in any state: it reaches the goal in every action space, and asking changes nothing."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin import (
    Discrete,
    EndEffectorPoseViaIK,
    EndEffectorPoseViaPlanning,
    EndEffectorVelocity,
    Environment,
    GripperJointPosition,
    JointPosition,
    JointTorque,
    JointVelocity,
    MoveArmThenGripper,
    SafeArm,
    TaskEnvironment,
)
from rlbench_pin.environment import ActionMode, JointPositionActionMode, expert_action, low_dim_config
from rlbench_pin.errors import DemoError, InvalidArgument, NotReset

MODES = {
    "joint positions": MoveArmThenGripper(JointPosition(), Discrete()),
    "joint differences, fingers": JointPositionActionMode(),
    "joint velocities": MoveArmThenGripper(JointVelocity(), Discrete()),
    "changes of velocity": MoveArmThenGripper(JointVelocity(absolute_mode=False), Discrete()),
    "safe": MoveArmThenGripper(SafeArm(JointVelocity()), Discrete()),
    "tip velocity": MoveArmThenGripper(EndEffectorVelocity(frame="end effector"), Discrete()),
    "tip poses": MoveArmThenGripper(EndEffectorPoseViaIK(), Discrete()),
    "tip poses, fingers": MoveArmThenGripper(EndEffectorPoseViaIK(absolute_mode=False), GripperJointPosition()),
    "key frames": MoveArmThenGripper(EndEffectorPoseViaPlanning(), Discrete()),
    "relative key frames": MoveArmThenGripper(EndEffectorPoseViaPlanning(absolute_mode=False), Discrete()),
    "key frames in the tip": MoveArmThenGripper(EndEffectorPoseViaPlanning(frame="end effector"), Discrete()),
}


def played(task: TaskEnvironment, seed: int, most: int = 400) -> int:
    """Actions of the expert until the goal is reached."""
    task.reset(seed=seed)
    for count in range(1, most + 1):
        _, reward, over = task.step(expert_action(task))
        if over:
            assert reward == 1.0
            return count
    raise AssertionError(f"the goal was not reached in {most} actions")


@pytest.mark.simulation
@pytest.mark.parametrize("mode", MODES.values(), ids=MODES.keys())
def test_the_goal_is_reached_in_every_action_space(mode: ActionMode) -> None:
    """Action by action; key frames are few."""
    with Environment(mode, obs_config=low_dim_config(), seed=0) as env:
        count = played(env.get_task("pick_and_lift"), seed=5000)
    assert (count < 10) == isinstance(mode.arm_action_mode, EndEffectorPoseViaPlanning)


@pytest.mark.simulation
@pytest.mark.parametrize("name", ["stack_blocks", "open_drawer", "push_buttons", "put_item_in_drawer"])
def test_rounds_and_doors(name: str) -> None:
    """Waypoints that are visited several times, and parts that move along curves."""
    with Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=low_dim_config(), seed=0) as env:
        played(env.get_task(name), seed=5000, most=500)


@pytest.mark.simulation
def test_asking_changes_nothing(lift: TaskEnvironment) -> None:
    """Asked twice, the answer is the same; the next step has the same bytes as without the question."""
    lift.reset(seed=3)
    time = lift.world.time
    first, again = expert_action(lift), expert_action(lift)
    assert first.tobytes() == again.tobytes()
    assert lift.world.time == time
    plain = lift.step(first)[0].get_low_dim_data().tobytes()
    lift.reset(seed=3)
    assert lift.step(first)[0].get_low_dim_data().tobytes() == plain


@pytest.mark.simulation
def test_it_helps_a_learner_that_strays(lift: TaskEnvironment) -> None:
    """After twenty actions of the expert and ten at random, the expert still reaches the goal."""
    rng = np.random.default_rng(1)
    for seed in (3, 4):
        lift.reset(seed=seed)
        for _ in range(20):
            lift.step(expert_action(lift))
        for _ in range(10):
            joints = np.asarray(lift.get_observation().joint_positions)
            lift.step(np.append(joints + rng.uniform(-0.05, 0.05, 7), 1.0))
        over, reward = False, 0.0
        for _ in range(300):
            _, reward, over = lift.step(expert_action(lift))
            if over:
                break
        assert reward == 1.0


@pytest.mark.simulation
def test_another_space_than_that_of_the_environment(lift: TaskEnvironment) -> None:
    """The action of a mode that is asked for."""
    lift.reset(seed=3)
    mode = MoveArmThenGripper(EndEffectorPoseViaPlanning(), Discrete())
    key_frame = expert_action(lift, mode)
    assert key_frame.shape == (9,)
    assert np.linalg.norm(key_frame[3:7]) == pytest.approx(1.0)
    assert expert_action(lift).shape == (8,)


def test_wrong_use_is_refused(lift: TaskEnvironment) -> None:
    """Before a reset, and in a space that it cannot be expressed in; each says why."""
    with Environment(MoveArmThenGripper(JointTorque(), Discrete()), obs_config=low_dim_config(), seed=0) as env:
        task = env.get_task("reach_target")
        with pytest.raises(NotReset):
            expert_action(task)
        task.reset(seed=0)
        with pytest.raises(InvalidArgument, match="cannot express"):
            expert_action(task)
    with pytest.raises(InvalidArgument):
        expert_action(lift, JointPosition())  # type: ignore[arg-type]


@pytest.mark.simulation
def test_a_hopeless_state_is_told(lift: TaskEnvironment) -> None:
    """Where the object is out of reach, the error names the waypoints that were tried."""
    lift.reset(seed=3)
    target = lift.world.body("target_block") if "target_block" in lift.world.bodies else next(iter(lift.world.bodies.values()))
    target.set_pose(np.array([2.0, 2.0, 0.1, 0.0, 0.0, 0.0, 1.0]))
    with pytest.raises(DemoError, match="from waypoint 0"):
        expert_action(lift)
