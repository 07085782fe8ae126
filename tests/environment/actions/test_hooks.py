"""The three hooks of an action: `pre_step`, `steps` and `post_step`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from rlbench_pin.environment import (
    ActionMode,
    ArmActionMode,
    Discrete,
    EndEffectorPoseViaIK,
    EndEffectorPoseViaPlanning,
    EndEffectorVelocity,
    Environment,
    GripperJointPosition,
    JointPosition,
    JointPositionActionMode,
    JointTorque,
    JointVelocity,
    MoveArmThenGripper,
    Runtime,
    SafeArm,
    TaskEnvironment,
)
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.errors import InvalidActionError
from rlbench_pin.spatial import FloatArray


class Together(ActionMode):
    """Any arm and gripper modes of one tick, in the same tick."""

    def pre_step(self, runtime: Runtime, values: FloatArray) -> None:
        """All pre-steps."""
        arm, gripper = self.split(runtime, values)
        self.arm_action_mode.pre_step(runtime, arm)
        self.gripper_action_mode.pre_step(runtime, gripper)

    def post_step(self, runtime: Runtime, values: FloatArray) -> None:
        """All post-steps."""
        arm, gripper = self.split(runtime, values)
        self.arm_action_mode.post_step(runtime, arm)
        self.gripper_action_mode.post_step(runtime, gripper)


def episode(chosen: ActionMode) -> TaskEnvironment:
    """An episode of reach_target."""
    task = Environment(chosen, obs_config=low_dim_config(), seed=0).get_task("reach_target")
    task.reset(seed=2)
    return task


def seen(task: TaskEnvironment, actions: list[FloatArray]) -> bytes:
    """Play actions and return everything that was observed."""
    return b"".join(task.step(action)[0].get_low_dim_data().tobytes() for action in actions)


def test_sharing_a_tick_is_the_joint_position_action_mode() -> None:
    """The hooks of its two parts give its very bytes; each action is one tick."""
    actions = [np.append(a, 0.02 + 0.02 * a[0]) for a in np.random.default_rng(0).uniform(-0.03, 0.03, (6, 7))]
    own = episode(Together(JointPosition(absolute_mode=False), GripperJointPosition()))
    began = own.world.time
    assert seen(own, actions) == seen(episode(JointPositionActionMode()), actions)
    assert own.world.time - began == pytest.approx(len(actions) * own.world.control_dt)


@pytest.mark.parametrize("make", [JointVelocity, JointPosition, JointTorque, EndEffectorVelocity], ids=lambda c: c.__name__)
def test_the_three_hooks_are_the_action(make: Callable[[], ArmActionMode]) -> None:
    """One after the other they do what `action` does."""
    low, high = (bound[:-1] for bound in episode(MoveArmThenGripper(make(), Discrete())).action_bounds())
    values = 0.5 * (low + high) + 0.1 * (high - low) * np.cos(np.arange(len(low)))
    whole, parts = (episode(MoveArmThenGripper(make(), Discrete())) for _ in range(2))
    for _ in range(3):
        whole.action_mode.arm_action_mode.action(whole.runtime, values)
        arm = parts.action_mode.arm_action_mode
        for hook in (arm.pre_step, arm.steps, arm.post_step):
            hook(parts.runtime, values)
    a, b = whole.get_observation(), parts.get_observation()
    assert a.get_low_dim_data().tobytes() == b.get_low_dim_data().tobytes()
    assert whole.world.time == parts.world.time


def test_the_step_of_a_motion_is_the_whole_motion() -> None:
    """Planned and solved poses and the opening gripper move in `steps` alone."""
    task = episode(MoveArmThenGripper(EndEffectorPoseViaPlanning(), Discrete()))
    for arm in (EndEffectorPoseViaPlanning(), EndEffectorPoseViaIK()):
        goal = task.get_observation().gripper_pose
        goal[2] -= 0.05
        began = task.world.time
        arm.pre_step(task.runtime, goal)
        assert task.world.time == began
        arm.steps(task.runtime, goal)
        assert task.world.time > began + task.world.control_dt
        after = task.world.time
        arm.post_step(task.runtime, goal)
        assert task.world.time == after
        np.testing.assert_allclose(task.get_observation().gripper_pose[:3], goal[:3], atol=5e-3)
    Discrete().steps(task.runtime, np.zeros(1))
    assert not task.runtime.gripper.is_open


def test_a_subclass_that_replaces_a_hook_is_obeyed() -> None:
    """A mode of one's own may change what is commanded, or what follows."""
    called: list[str] = []

    class Slow(JointVelocity):
        def pre_step(self, runtime: Runtime, values: FloatArray) -> None:
            called.append("before")
            super().pre_step(runtime, 0.5 * values)

        def post_step(self, runtime: Runtime, values: FloatArray) -> None:
            called.append("after")
            super().post_step(runtime, values)

    fast, slow = (episode(MoveArmThenGripper(arm, Discrete())) for arm in (JointVelocity(), Slow()))
    action = np.append(np.full(7, 0.2), 1.0)
    moved = [task.step(action)[0].joint_positions - task.runtime.description.home for task in (fast, slow)]
    assert called == ["before", "after"]
    np.testing.assert_allclose(moved[1], 0.5 * moved[0], rtol=0.1, atol=1e-3)


def test_the_filter_acts_on_shared_ticks() -> None:
    """SafeArm in a shared tick stops a bad policy in front of the table; without it the arm hits the table."""
    action = np.zeros(8)
    action[1], action[3], action[7] = 0.8, -0.4, 0.04
    touching = []
    for arm in (SafeArm(JointVelocity()), JointVelocity()):
        task = episode(Together(arm, GripperJointPosition()))
        for _ in range(60):
            task.step(action)
        touching.append("table" in task.world.robot.touching())
    assert touching == [False, True]


def test_hooks_of_the_filter_are_its_action() -> None:
    """The same bytes and the same count of interventions, for modes of one tick and of many."""
    for make, values in ((JointVelocity, np.full(7, 0.8)), (EndEffectorPoseViaIK, None)):
        whole, parts = (episode(MoveArmThenGripper(SafeArm(make()), Discrete())) for _ in range(2))
        target = whole.get_observation().gripper_pose + [0, 0, -0.1, 0, 0, 0, 0] if values is None else values
        whole.action_mode.arm_action_mode.action(whole.runtime, target)
        arm = parts.action_mode.arm_action_mode
        for hook in (arm.pre_step, arm.steps, arm.post_step):
            hook(parts.runtime, target)
        a, b = whole.get_observation(), parts.get_observation()
        assert a.get_low_dim_data().tobytes() == b.get_low_dim_data().tobytes()
        assert arm.counts == whole.action_mode.arm_action_mode.counts  # type: ignore[attr-defined]


def test_the_end_of_a_finger_motion_needs_its_beginning() -> None:
    """The error says which hook to call first."""
    task = episode(MoveArmThenGripper(JointPosition(), GripperJointPosition()))
    with pytest.raises(InvalidActionError, match="pre_step"):
        task.action_mode.gripper_action_mode.post_step(task.runtime, np.zeros(1))
