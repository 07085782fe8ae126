"""Action modes of the arm."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import cast

import numpy as np

from pyrep.const import ConfigurationPathAlgorithms as Algos
from pyrep.const import ObjectType
from pyrep.errors import ConfigurationPathError, IKError
from pyrep.objects.object import Object
from rlbench.backend.robot import Robot
from rlbench.backend.scene import Scene
from rlbench.const import SUPPORTED_ROBOTS
from rlbench_pin.compat import actions
from rlbench_pin.compat.actions import (
    Action,
    OneStepPart,
    RelativeFrame,
    ScenePart,
    UserMode,
    assert_action_shape,
    calculate_delta_pose,
    pose_in_end_effector_frame,
    setting,
)
from rlbench_pin.compat.simulator import SceneLike, runtime_of
from rlbench_pin.environment.actions import modes, pose
from rlbench_pin.environment.actions.modes import FrameChoice, as_frame, assert_unit_quaternion
from rlbench_pin.errors import InvalidActionError
from rlbench_pin.observation import Observation
from rlbench_pin.spatial import FloatArray, compose

__all__ = [
    "SUPPORTED_ROBOTS",
    "Algos",
    "ArmActionMode",
    "ConfigurationPathError",
    "ERJointViaIK",
    "EndEffectorPoseViaIK",
    "EndEffectorPoseViaPlanning",
    "IKError",
    "InvalidActionError",
    "JointPosition",
    "JointTorque",
    "JointVelocity",
    "ObjectType",
    "RelativeFrame",
    "Robot",
    "Scene",
    "assert_action_shape",
    "assert_unit_quaternion",
    "calculate_delta_pose",
    "takes_ignore_collisions",
]


class ArmActionMode(UserMode):
    """Base class of arm modes: converts the values of an action to motions of the arm."""

    def set_control_mode(self, robot: Robot) -> None:
        """Switch the arm to the control mode that the action mode needs, by default position control."""
        robot.arm.set_control_loop_enabled(True)


class JointVelocity(OneStepPart, modes.JointVelocity, ArmActionMode):
    """Joint velocities [rad/s] for one step; then the arm stops."""

    def set_control_mode(self, robot: Robot) -> None:
        """Switch the arm to velocity control."""
        robot.arm.set_control_loop_enabled(False)
        robot.arm.set_motor_locked_at_zero_velocity(True)


class JointPosition(OneStepPart, modes.JointPosition, ArmActionMode):
    """Joint positions [rad], or differences to the measured ones: one step towards them, then the arm stops.

    Args:
        absolute_mode: Use positions; otherwise differences.
    """

    _absolute_mode = setting("absolute_mode")


class JointTorque(OneStepPart, modes.JointTorque, ArmActionMode):
    """Joint torques [N m] for one step, including those against gravity, positive in the direction of the joint; then stop."""

    def set_control_mode(self, robot: Robot) -> None:
        """Switch position control of the arm off."""
        robot.arm.set_control_loop_enabled(False)


class PosePart(ScenePart, pose.PoseMode):
    """Settings of modes whose actions begin with a tip pose, with the attribute names of RLBench."""

    _absolute_mode = setting("absolute_mode")

    @property
    def _frame(self) -> RelativeFrame:
        return RelativeFrame(int(self.frame))

    @_frame.setter
    def _frame(self, value: RelativeFrame | str) -> None:
        self.frame = as_frame(cast(FrameChoice, value))

    _collision_checking = setting("collision_checking")

    def _pose_in_end_effector_frame(self, robot: Robot, action: Action) -> FloatArray:
        """Return the world pose (7,) of a pose that is given in the frame of the tip."""
        return pose_in_end_effector_frame(robot, action)


class EndEffectorPoseViaPlanning(PosePart, pose.EndEffectorPoseViaPlanning, ArmActionMode):
    """A tip pose (7,): plan a timed, smooth motion there and execute it to its end, or until the episode ends.

    Args:
        absolute_mode: Use world poses; otherwise deltas to the current tip pose.
        frame: Frame of the delta: an item of `RelativeFrame`, 'world' or 'end effector'. With the frame of the end effector the
            pose is relative for any `absolute_mode`.
        collision_checking: Plan around obstacles, unless the action overrides it.
    """

    _callable_each_step: actions.OnStep | None = None
    _robot_shapes: list[Object] | None = None  # derived classes of programs set it

    def action(self, scene: SceneLike, action: object, ignore_collisions: bool | None = None) -> None:
        """Plan and execute one motion.

        Args:
            scene: The scene of the arm.
            action: Tip pose (7,): x, y, z [m], qx, qy, qz, qw.
            ignore_collisions: None: as `collision_checking`. True: without collision checks. False: around obstacles, or without
                collision checks if that fails.

        Raises:
            InvalidActionError: The pose is invalid or cannot be reached; the arm has not moved.
        """
        target = self.target(runtime_of(scene), self.values(scene, action))
        ignore = not self.collision_checking if ignore_collisions is None else bool(ignore_collisions)
        plan = actions.plan_motion(scene, target, ignore, second_try=ignore_collisions is not None)
        actions.run(scene, plan, self._callable_each_step)

    def set_callable_each_step(self, callable_each_step: Callable[[Observation], object] | None) -> None:
        """Call a function with an observation after each step of a motion; motions then continue when the episode ends."""
        self._callable_each_step = callable_each_step

    def record_end(self, scene: SceneLike, steps: int = 60, step_scene: bool = True) -> None:
        """Pass additional observations to the function of `set_callable_each_step`.

        Args:
            scene: The scene.
            steps: Number of observations.
            step_scene: Step the simulation before each.
        """
        for _ in range(steps if self._callable_each_step is not None else 0):
            if step_scene:
                scene.step()
            self._callable_each_step(scene.get_observation())  # type: ignore[misc]

    def action_shape(self, scene: SceneLike | None = None) -> tuple[int]:
        """Return the shape of an action, (7,)."""
        return (7,)

    def _quick_boundary_check(self, scene: SceneLike, action: Action) -> None:
        """Raise InvalidActionError if a pose (7,), in the world or in the frame of the tip, is outside the workspace."""
        target = np.asarray(action, dtype=float)
        if self._frame == RelativeFrame.EE:
            target = compose(runtime_of(scene).robot.tip_pose(), target)
        runtime_of(scene).check_target_in_workspace(target[:3])


class EndEffectorPoseViaIK(PosePart, pose.EndEffectorPoseViaIK, ArmActionMode):
    """A tip pose (7,): solve inverse kinematics near the current configuration and move the joints there.

    Args:
        absolute_mode: Use world poses; otherwise deltas to the current tip pose.
        frame: As for `EndEffectorPoseViaPlanning`.
        collision_checking: No effect: the motion has no collision checks.
    """

    def action_shape(self, scene: SceneLike | None = None) -> tuple[int]:
        """Return the shape of an action, (7,)."""
        return (7,)


class ERJointViaIK(PosePart, pose.ERJointViaIK, ArmActionMode):
    """A tip pose and the angles of some joints; inverse kinematics solves for the other joints.

    Args:
        absolute_mode: Use world poses and absolute angles; otherwise deltas.
        frame: As for `EndEffectorPoseViaPlanning`.
        collision_checking: No effect: the motion has no collision checks.
        commanded_joints: Indices of the joints with given angles.
        eps: Joint error at which the action ends [rad].
        delta_angle: The angle is a delta; needs relative mode and one joint, the first or the last.
    """


def takes_ignore_collisions(mode: object) -> bool:
    """Return whether the method `action` of an arm mode has the argument `ignore_collisions`."""
    return "ignore_collisions" in inspect.signature(mode.action).parameters  # type: ignore[attr-defined]
