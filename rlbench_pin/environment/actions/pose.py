"""Arm modes with a tip pose as target: by planning, by inverse kinematics, or with some joints pinned."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from rlbench_pin.environment.actions.modes import (
    POSE_NAMES,
    POSE_UNITS,
    ActionSpec,
    ArmActionMode,
    FrameChoice,
    RelativeFrame,
    as_action,
    as_frame,
    assert_unit_quaternion,
    calculate_delta_pose,
)
from rlbench_pin.environment.runtime import TIP_WORKSPACE, Runtime, follow
from rlbench_pin.errors import InvalidActionError, PlanningError, shown
from rlbench_pin.planning.kinematics import solve_ik, solve_pinned_ik
from rlbench_pin.planning.plan import Plan
from rlbench_pin.spatial import FloatArray, compose, inverse, relative
from rlbench_pin.values import as_flag, as_number, as_whole, items_of

IK_DONE = 0.01
"""Joint error at which an IK action ends [rad]."""
IK_STALLED = 0.001
"""Joint motion in one tick below which an IK action ends too [rad]."""
IK_TICKS, PINNED_IK_TICKS = 200, 50
"""Maximum number of ticks of an action, without and with pinned joints; more for slow arms, see `RobotModel.slowness`."""


class PoseMode(ArmActionMode):
    """Base class of modes whose first values are a tip pose (7,).

    Args:
        absolute_mode: The pose is in the world; otherwise it is a delta to the present tip pose.
        frame: Frame of the delta; with the end-effector frame the pose is a delta for any `absolute_mode`.
        collision_checking: Avoid collisions in planned motions; inverse kinematics does not check them.
    """

    def __init__(
        self, absolute_mode: bool = True, frame: FrameChoice = RelativeFrame.WORLD, collision_checking: bool = False
    ) -> None:
        self.absolute_mode, self.frame = as_flag(absolute_mode, "absolute_mode"), as_frame(frame)
        self.collision_checking = as_flag(collision_checking, "collision_checking")

    @property
    def is_relative(self) -> bool:
        """Whether the pose is a delta."""
        return not self.absolute_mode or self.frame is RelativeFrame.EE

    def spec(self, runtime: Runtime) -> ActionSpec:
        """Return the position and the quaternion; the bounds of the position are the workspace."""
        extent = TIP_WORKSPACE[1] - TIP_WORKSPACE[0]
        low, high = (-extent, extent) if self.is_relative else (TIP_WORKSPACE[0], TIP_WORKSPACE[1])
        frame = "end effector" if self.frame is RelativeFrame.EE else "world"
        ones = np.ones(4)
        return ActionSpec(POSE_NAMES, POSE_UNITS, np.concatenate([low, -ones]), np.concatenate([high, ones]), frame, None)

    def action_to(self, goal: FloatArray, here: FloatArray) -> FloatArray:
        """Return the action (7,) whose target is a world pose `goal` (7,) when the tip pose is `here` (7,)."""
        if not self.is_relative:
            return goal
        if self.frame is RelativeFrame.EE:
            return relative(goal, here)
        turn = compose([0.0, 0.0, 0.0, *goal[3:]], inverse([0.0, 0.0, 0.0, *here[3:]]))
        return np.concatenate([goal[:3] - here[:3], turn[3:]])

    def target(self, runtime: Runtime, pose: FloatArray) -> FloatArray:
        """Return the target world pose (7,) of an action, or raise InvalidActionError."""
        assert_unit_quaternion(pose[3:])
        return calculate_delta_pose(runtime.robot.tip_pose(), pose, self.frame) if self.is_relative else pose


class EndEffectorPoseViaPlanning(PoseMode):
    """Plan a timed, smooth motion to the pose and run it to its end, or until the episode is over.

    A position outside the workspace box, or a pose without a plan, raises InvalidActionError.

    An optional eighth value follows the pose: above 0.5 it ignores collisions, otherwise it avoids them. Without it,
    `collision_checking` applies.

    Args:
        absolute_mode: The pose is in the world; otherwise it is a delta to the present tip pose.
        frame: Frame of the delta; with the end-effector frame the pose is a delta for any `absolute_mode`.
        collision_checking: Avoid collisions.
        retry_without_checks: If no motion without collisions is found, plan one that ignores them, instead of an error.
    """

    def __init__(
        self,
        absolute_mode: bool = True,
        frame: FrameChoice = RelativeFrame.WORLD,
        collision_checking: bool = False,
        *,
        retry_without_checks: bool = False,
    ) -> None:
        super().__init__(absolute_mode, frame, collision_checking)
        self.retry_without_checks = as_flag(retry_without_checks, "retry_without_checks")

    @property
    def optional_values(self) -> int:
        """One optional value: whether collisions are ignored."""
        return 1

    def action(self, runtime: Runtime, action: object, ignore_collisions: bool | None = None) -> None:
        """Check one action, then plan and run it.

        Args:
            runtime: Runtime of the arm.
            action: A pose (7,), optionally with the eighth value.
            ignore_collisions: Overrides the eighth value and the setting; None does not.

        Raises:
            InvalidActionError: The action is invalid; nothing has moved.
        """
        if ignore_collisions is not None:
            values = as_action(action, 7, type(self).__name__, self.optional_values)
            action = np.append(values[:7], float(ignore_collisions))
        super().action(runtime, action)

    def check(self, runtime: Runtime, values: FloatArray) -> FloatArray:
        """Return the values, or raise InvalidActionError if the eighth is not between 0 and 1."""
        if len(values) > 7 and not 0.0 <= values[7] <= 1.0:
            raise InvalidActionError(
                f"The optional last value of the pose is {values[7]}; it must be 0 (avoid collisions) or 1 (ignore collisions)."
            )
        return values

    def steps(self, runtime: Runtime, values: FloatArray) -> None:
        """Plan and execute."""
        target = self.target(runtime, values[:7])
        runtime.check_target_in_workspace(target[:3])
        runtime.refresh_planner()
        ignore = bool(values[7] > 0.5) if len(values) > 7 else not self.collision_checking
        try:
            plan = self._plan(runtime, target, ignore)
        except PlanningError as error:
            raise InvalidActionError(f"No motion to the target pose: {error}", error.reason) from error
        follow(runtime, plan.trajectory)

    def _plan(self, runtime: Runtime, target: FloatArray, ignore_collisions: bool) -> Plan:
        q, allowed, rng = runtime.measured_start, runtime.touching(), runtime.planning_rng
        try:
            return runtime.planner.plan_to_pose(q, target, ignore_collisions=ignore_collisions, allowed=allowed, rng=rng)
        except PlanningError:
            if ignore_collisions or not self.retry_without_checks:
                raise
        return runtime.planner.plan_to_pose(q, target, ignore_collisions=True, allowed=allowed, rng=rng)


class EndEffectorPoseViaIK(PoseMode):
    """Solve inverse kinematics near the present posture and move the joints there, until they arrive or stall.

    An action takes at most 200 ticks, more for slow arms. A pose without a solution near the present joint positions raises
    InvalidActionError.
    """

    def steps(self, runtime: Runtime, values: FloatArray) -> None:
        """Solve and move until the joints arrive or stall."""
        target = self.target(runtime, values)
        q = runtime.robot.joint_positions
        try:
            goal = solve_ik(runtime.model, target, q, runtime.planning_rng, starts=1)[0]
        except PlanningError as error:
            raise InvalidActionError(
                f"No joint positions near the present ones reach the target pose: {error}", error.reason
            ) from error
        drive_until_there(runtime, goal, IK_DONE, IK_TICKS)


class ERJointViaIK(PoseMode):
    """A tip pose and the angles of some joints ("elbow" control): these joints are pinned, the others are solved for.

    An action takes at most 50 ticks, more for slow arms. Angles are clipped to the joint limits. A pose that these angles cannot
    reach raises InvalidActionError.

    Args:
        absolute_mode: World pose and absolute angles; otherwise deltas.
        frame: Frame of the pose.
        collision_checking: Has no effect; the motion is not checked.
        commanded_joints: Indices of the pinned joints.
        eps: Joint error at which the action ends [rad].
        delta_angle: The angle is a delta; needs relative mode and one joint, the first or the last.
    """

    def __init__(
        self,
        absolute_mode: bool = True,
        frame: FrameChoice = RelativeFrame.WORLD,
        collision_checking: bool = False,
        commanded_joints: Sequence[int] = (0,),
        eps: float = 1e-3,
        delta_angle: bool = False,
    ) -> None:
        super().__init__(absolute_mode, frame, collision_checking)
        joints = items_of(commanded_joints)
        self.commanded_joints = tuple(as_whole(joint, "a commanded joint", least=0, most=99) for joint in joints)
        self.eps, self.delta_angle = as_number(eps, "eps", above=0.0), as_flag(delta_angle, "delta_angle")
        if len(set(joints)) != len(joints) or (not joints and not isinstance(commanded_joints, list | tuple)):
            raise InvalidActionError(
                f"commanded_joints has to be a list of different joint indices, not {shown(commanded_joints)}."
            )
        if delta_angle and absolute_mode:
            raise InvalidActionError(
                "delta_angle=True needs absolute_mode=False. Pass absolute_mode=False, or delta_angle=False."
            )

    def spec(self, runtime: Runtime) -> ActionSpec:
        """Return the pose, then the pinned angles."""
        joints, last = list(self.commanded_joints), runtime.model.size - 1
        if self.delta_angle and joints not in ([0], [last]):
            raise NotImplementedError(f"delta_angle supports only one commanded joint, 0 or {last}, not {joints}.")
        if max(joints, default=0) > last:
            raise InvalidActionError(f"The arm has joints 0 to {last}, not {max(joints)}. Change commanded_joints.")
        limits = runtime.model.limits
        names = tuple(runtime.description.arm_joints[j] for j in joints)
        low, high = limits.lower[joints], limits.upper[joints]
        if not self.absolute_mode:
            low, high = low - high, high - low
        angles = ActionSpec(names, ("rad",) * len(joints), low, high, "joint", None)
        return super().spec(runtime).joined(angles)

    def steps(self, runtime: Runtime, values: FloatArray) -> None:
        """Solve with the pinned joints and move there."""
        target = self.target(runtime, values[:7])
        q = runtime.robot.joint_positions
        joints = list(self.commanded_joints)
        angles = values[7:] if self.absolute_mode else q[joints] + values[7:]
        limits = runtime.model.limits
        angles = np.clip(angles, limits.lower[joints], limits.upper[joints])
        try:
            goal = solve_pinned_ik(runtime.model, target, q, dict(zip(joints, angles.tolist(), strict=True)))
        except PlanningError as error:
            raise InvalidActionError(
                f"The pose cannot be reached with joints {joints} at {angles.round(3)}: {error}", error.reason
            ) from error
        drive_until_there(runtime, goal, self.eps, PINNED_IK_TICKS)


def drive_until_there(runtime: Runtime, goal: FloatArray, tolerance: float, ticks: int) -> None:
    """Move the joints to `goal` (n,) [rad] until they are within `tolerance` or stall, or the ticks or the episode end.

    Args:
        runtime: Runtime of the arm.
        goal: Joint positions.
        tolerance: Error at which the motion ends [rad].
        ticks: Maximum number of control ticks for the Panda; slower arms take more, see `RobotModel.slowness`.
    """
    before = runtime.robot.joint_positions
    for _ in range(math.ceil(ticks * runtime.model.slowness)):
        runtime.drive_to(goal)
        now = runtime.robot.joint_positions
        if runtime.over or np.abs(now - goal).max() < tolerance or np.abs(now - before).max() < IK_STALLED:
            return
        before = now
