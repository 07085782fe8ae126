"""Action modes that programs write: derived from the known classes, on the scene, the arm and its paths."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from pyrep.errors import ConfigurationPathError, IKError
from rlbench.action_modes.action_mode import ActionMode, JointPositionActionMode, MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import (
    Algos,
    ArmActionMode,
    EndEffectorPoseViaPlanning,
    JointPosition,
    JointVelocity,
    assert_action_shape,
    assert_unit_quaternion,
    calculate_delta_pose,
)
from rlbench.action_modes.gripper_action_modes import Discrete, GripperActionMode, GripperJointPosition
from rlbench.backend.exceptions import InvalidActionError
from rlbench.backend.scene import Scene
from rlbench.environment import Environment
from tests.compat.scenes import fresh_scene, launched

DOWN = [0.0, 1.0, 0.0, 0.0]


@pytest.fixture(scope="module")
def environment() -> Iterator[Environment]:
    """An environment without pictures."""
    yield from launched()


@pytest.fixture
def scene(environment: Environment) -> Any:
    """The scene of a fresh episode."""
    return fresh_scene(environment)


class CarefulPlanning(EndEffectorPoseViaPlanning):
    """A planning mode that follows paths by itself, and plans again without checks."""

    def action(self, scene: Scene, action: np.ndarray, ignore_collisions: bool = True) -> None:  # type: ignore[override]
        """Plan, then step path and scene in turn."""
        assert_action_shape(action, (7,))
        assert_unit_quaternion(action[3:])
        self._quick_boundary_check(scene, action)
        self.flags = [*getattr(self, "flags", []), ignore_collisions]
        try:
            path = scene.robot.arm.get_path(
                action[:3],
                quaternion=action[3:],
                ignore_collisions=ignore_collisions,
                trials=100,
                max_configs=10,
                max_time_ms=10,
                trials_per_goal=5,
                algorithm=Algos.RRTConnect,
            )
        except ConfigurationPathError as error:
            raise InvalidActionError("No path.") from error
        done = False
        while not done:
            done = path.step()
            scene.step()
            success, _ = scene.task.success()
            if success:
                break


class NineValues(MoveArmThenGripper):
    """A mode that splits nine values by itself."""

    def action(self, scene: Scene, action: np.ndarray) -> None:  # type: ignore[override]
        """Give the last value to the arm."""
        size = int(np.prod(self.arm_action_mode.action_shape(scene)))
        arm, hand, ignore = np.array(action[:size]), np.array(action[size : size + 1]), bool(action[-1])
        self.arm_action_mode.action(scene, arm, ignore)  # type: ignore[call-arg]
        self.gripper_action_mode.action(scene, hand)


def test_a_planning_mode_of_ones_own(scene: Any) -> None:
    """It reaches its goal by stepping path and scene, and refuses what has no path."""
    mode = MoveArmThenGripper(CarefulPlanning(), Discrete())
    mode.action(scene, np.array([0.3, 0.1, 1.2, *DOWN, 0.0]))
    np.testing.assert_allclose(scene.robot.arm.get_tip().get_position(), [0.3, 0.1, 1.2], atol=1e-3)
    assert max(scene.robot.gripper.get_open_amount()) < 0.05
    with pytest.raises(InvalidActionError, match="No path"):
        mode.action(scene, np.array([0.77, 0.65, 1.74, *DOWN, 0.0]))
    with pytest.raises(InvalidActionError, match="workspace"):
        mode.action(scene, np.array([0.3, 0.1, 9.0, *DOWN, 0.0]))


@pytest.mark.parametrize("whole", [NineValues, MoveArmThenGripper])
def test_nine_values_reach_the_users_arm_mode(scene: Any, whole: type[MoveArmThenGripper]) -> None:
    """Whether the user splits them or the built-in mode does."""
    arm = CarefulPlanning()
    for flag in (1.0, 0.0):
        whole(arm, Discrete()).action(scene, np.array([0.3, 0.1, 1.2 + 0.1 * flag, *DOWN, 1.0, flag]))
    assert arm.flags == [True, False]


class Hooked(JointPosition):
    """Counts its own hooks."""

    calls: tuple[str, ...] = ()

    def action_pre_step(self, scene: Any, action: Any) -> None:
        """Note, then do as built in."""
        self.calls += ("pre",)
        super().action_pre_step(scene, action)

    def action_post_step(self, scene: Any, action: Any) -> None:
        """Note, then do as built in."""
        self.calls += ("post",)
        super().action_post_step(scene, action)


def test_hooks_of_a_derived_mode_are_called(scene: Any) -> None:
    """Before and after the step."""
    mode = Hooked()
    before = np.array(scene.robot.arm.get_joint_positions())
    MoveArmThenGripper(mode, Discrete()).action(scene, [*(before + 0.01), 1.0])
    assert mode.calls == ("pre", "post")
    np.testing.assert_allclose(scene.robot.arm.get_joint_positions(), before + 0.01, atol=2e-3)


class BothAtOnce(ActionMode):
    """Arm and hand within the same steps, by the three hooks of both parts."""

    def action(self, scene: Scene, action: np.ndarray) -> None:  # type: ignore[override]
        """Command both, step, end both."""
        arm, hand = np.array(action[:7]), np.array(action[7:])
        self.arm_action_mode.action_pre_step(scene, arm)
        self.gripper_action_mode.action_pre_step(scene, hand)
        scene.step()
        self.arm_action_mode.action_post_step(scene, arm)
        self.gripper_action_mode.action_post_step(scene, hand)

    def action_shape(self, scene: Scene) -> int:  # type: ignore[override]
        """Seven joints and the hand."""
        return 8


@pytest.mark.parametrize(("hand", "closed"), [(GripperJointPosition(), 0.0), (Discrete(), 0.0)])
def test_a_whole_mode_of_ones_own(scene: Any, hand: Any, closed: float) -> None:
    """Arm and fingers move in the same steps."""
    mode, ticks = BothAtOnce(JointVelocity(), hand), scene.runtime.world.ticks
    before = np.array(scene.robot.arm.get_joint_positions())
    for _ in range(6):
        mode.action(scene, np.array([0.1] * 7 + [closed]))
    assert scene.runtime.world.ticks == ticks + 6
    np.testing.assert_allclose(scene.robot.arm.get_joint_positions() - before, 0.03, atol=5e-3)
    assert max(scene.robot.gripper.get_open_amount()) < 0.1
    with pytest.raises(NotImplementedError, match="action_bounds"):
        mode.action_bounds()


class JointsByConstructor(JointPositionActionMode):
    """Replaces the parts, past the constructor of its base."""

    def __init__(self) -> None:
        super(JointPositionActionMode, self).__init__(JointPosition(True), GripperJointPosition(True))


def test_parts_of_the_joint_position_mode_can_be_replaced(scene: Any) -> None:
    """Absolute joint positions in place of differences."""
    q = np.array(scene.robot.arm.get_joint_positions()) + 0.02
    JointsByConstructor().action(scene, [*q, 0.04])
    np.testing.assert_allclose(scene.robot.arm.get_joint_positions(), q, atol=3e-3)


class DeltaByJacobian(ArmActionMode):
    """A Cartesian delta, by inverse kinematics of the arm and joint targets."""

    def action(self, scene: Scene, action: np.ndarray) -> None:  # type: ignore[override]
        """Solve, and step until the joints are there."""
        pose = calculate_delta_pose(scene.robot, action)
        try:
            joints = scene.robot.arm.solve_ik_via_jacobian(pose[:3], quaternion=pose[3:])
        except IKError as error:
            raise InvalidActionError("Cannot be reached.") from error
        scene.robot.arm.set_joint_target_positions(joints)
        for _ in range(50):
            scene.step()
            if np.allclose(scene.robot.arm.get_joint_positions(), joints, atol=2e-3):
                return

    def action_shape(self, scene: Scene) -> tuple[int]:  # type: ignore[override]
        """A pose."""
        return (7,)


class Squeeze(GripperActionMode):
    """Closes by `actuate`, and grasps what the task lets it."""

    def action(self, scene: Scene, action: np.ndarray) -> None:  # type: ignore[override]
        """Actuate until done."""
        done = False
        while not done:
            done = scene.robot.gripper.actuate(float(action[0]), velocity=0.2)
            scene.step()
        for graspable in scene.task.get_graspable_objects():
            scene.robot.gripper.grasp(graspable)

    def action_shape(self, scene: Scene) -> tuple[int]:  # type: ignore[override]
        """One number."""
        return (1,)


def test_parts_of_ones_own_in_the_built_in_mode(scene: Any) -> None:
    """They see the scene, and their shapes add up."""
    mode = MoveArmThenGripper(DeltaByJacobian(), Squeeze())
    assert mode.action_shape(scene) == 8
    start = scene.robot.arm.get_tip().get_position()
    mode.action(scene, [0.0, 0.04, -0.05, 0, 0, 0, 1, 0.3])
    np.testing.assert_allclose(scene.robot.arm.get_tip().get_position(), start + [0.0, 0.04, -0.05], atol=3e-3)
    assert scene.robot.gripper.get_open_amount() == pytest.approx([0.3, 0.3], abs=0.03)
    with pytest.raises(InvalidActionError, match="Cannot be reached"):
        mode.action(scene, [5.0, 0.0, 0.0, 0, 0, 0, 1, 0.3])


class VelocityByCommand(JointVelocity):
    """Commands the arm itself, as the built-in mode of others does."""

    def action(self, scene: Scene, action: np.ndarray) -> None:  # type: ignore[override]
        """Go for three steps, then stop."""
        scene.robot.arm.set_joint_target_velocities(action)
        for _ in range(3):
            scene.step()
        scene.robot.arm.set_joint_target_velocities(np.zeros_like(action))


def test_a_velocity_mode_of_ones_own(scene: Any) -> None:
    """Three steps at 0.2 rad/s, whatever the arm did before."""
    before = np.array(scene.robot.arm.get_joint_positions())
    MoveArmThenGripper(VelocityByCommand(), Discrete()).action(scene, np.array([0.2] * 7 + [1.0]))
    np.testing.assert_allclose(scene.robot.arm.get_joint_positions() - before, 0.03, atol=5e-3)
