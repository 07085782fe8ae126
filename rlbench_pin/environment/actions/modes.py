"""Action modes: shape, bounds, checks, joint modes and gripper modes."""

from __future__ import annotations

import math
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from enum import IntEnum
from typing import Literal, TypeVar

import numpy as np

from rlbench_pin.control.differential_ik import DifferentialIK, DifferentialIKConfig
from rlbench_pin.environment.runtime import RefusedOpening, Runtime, hold_or_release, move_gripper
from rlbench_pin.errors import InvalidActionError, InvalidArgument, InvalidValue, shown
from rlbench_pin.spatial import FloatArray, compose
from rlbench_pin.values import as_array, as_flag, as_vector

POSE_NAMES = ("x", "y", "z", "qx", "qy", "qz", "qw")
POSE_UNITS = ("m", "m", "m", "1", "1", "1", "1")
TWIST_NAMES = ("vx", "vy", "vz", "wx", "wy", "wz")
TWIST_UNITS = ("m/s", "m/s", "m/s", "rad/s", "rad/s", "rad/s")


@dataclass(frozen=True, eq=False)
class ActionSpec:
    """The values of one action, in order."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    low: FloatArray
    """Lowest values, shape (n,), read-only."""
    high: FloatArray
    """Highest values, shape (n,), read-only."""
    frame: str
    """Frame of Cartesian values, or `joint`."""
    ticks: int | None
    """Number of control ticks of one action; None if it depends on the motion."""

    def __post_init__(self) -> None:
        if not len(self.names) == len(self.units) == len(self.low) == len(self.high):
            raise ValueError(f"{len(self.names)} names, {len(self.units)} units and {len(self.low)} bounds must be equally many")
        for name in ("low", "high"):
            bound = np.array(getattr(self, name), dtype=float)
            bound.setflags(write=False)
            object.__setattr__(self, name, bound)

    @property
    def size(self) -> int:
        """Number of values of an action."""
        return len(self.names)

    def joined(self, other: ActionSpec) -> ActionSpec:
        """Return the specification of this action followed by another."""
        ticks = None if self.ticks is None or other.ticks is None else self.ticks + other.ticks
        return ActionSpec(
            (*self.names, *other.names),
            (*self.units, *other.units),
            np.concatenate([self.low, other.low]),
            np.concatenate([self.high, other.high]),
            self.frame,
            ticks,
        )


class Mode:
    """Base class of all modes, which define the values of an action (`spec`) and execute it.

    `action` checks one action and runs `pre_step`, `steps` and `post_step`. A mode whose action takes one control tick overrides
    `pre_step` and `post_step`, and sets `ticks` to 1. Then other modes can share the tick: all pre-steps, one `runtime.step()`,
    all post-steps. A mode whose number of ticks depends on the motion overrides `steps`.

    A mode contains only settings, which may be changed at any time, so several environments can share one mode. Data of one
    environment belongs in `runtime.kept`.

    Attributes:
        ticks: Number of control ticks of one action; None if it depends on the motion.
    """

    ticks: int | None = None

    @property
    def optional_values(self) -> int:
        """Number of optional values after those of the specification; an action has all of them or none."""
        return 0

    def spec(self, runtime: Runtime) -> ActionSpec:
        """Return names, units, bounds and frame of the values."""
        raise NotImplementedError(
            f"{type(self).__name__} has no method `spec(runtime)`, which its shape and bounds need. Add this method."
        )

    def shape(self, runtime: Runtime) -> tuple[int]:
        """Return the shape of an action, without optional values."""
        return (self.spec(runtime).size,)

    def bounds(self, runtime: Runtime) -> tuple[FloatArray, FloatArray]:
        """Return lowest and highest values of an action, each of shape (n,)."""
        spec = self.spec(runtime)
        return spec.low.copy(), spec.high.copy()

    def check(self, runtime: Runtime, values: FloatArray) -> FloatArray:
        """Return the finite `values` (n,) or replacements for them, or raise InvalidActionError to reject them."""
        return values

    def pre_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Prepare the tick of an action (n,), such as the motor commands, without a simulation step. Default: nothing."""

    def steps(self, runtime: Runtime, values: FloatArray) -> None:
        """Run the ticks of an action (n,). Default: one tick."""
        runtime.step()

    def post_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Finish the tick of an action (n,), such as by stopping the arm, without a simulation step. Default: nothing."""

    def run(self, runtime: Runtime, values: FloatArray) -> None:
        """Run one checked action (n,) to its end."""
        self.pre_step(runtime, values)
        self.steps(runtime, values)
        self.post_step(runtime, values)

    def action(self, runtime: Runtime, action: object) -> None:
        """Check one action, then run it to its end, or until the episode is over.

        Raises:
            InvalidActionError: The action is invalid; nothing has moved.
        """
        values = as_action(action, self.shape(runtime)[0], type(self).__name__, self.optional_values)
        self.run(runtime, self.check(runtime, values))


class ArmActionMode(Mode):
    """Base class of modes that convert the values of an action to arm motion."""

    def refused_opening(self, runtime: Runtime, fingers: FloatArray) -> RefusedOpening | None:
        """Return the reason why the fingers must not open to `fingers` (2,) [m]; None if they may. Default: None."""
        return None

    def protected(self, runtime: Runtime) -> AbstractContextManager[None]:
        """Return a context in which the arm stays safe while the gripper moves. Default: no effect."""
        return nullcontext()


class GripperActionMode(Mode):
    """Base class of modes that convert the values of an action to finger motion."""

    def opening(self, runtime: Runtime, values: FloatArray) -> FloatArray | None:
        """Return the finger positions (2,) [m] after an opening action (n,); None if it does not open. Default: None."""
        return None


class ActionMode(Mode):
    """An arm mode and a gripper mode. Subclasses define their order in `steps`, or in `pre_step` and `post_step`.

    Optional values of the arm mode are the last values of the action.

    Args:
        arm_action_mode: Mode of the first values.
        gripper_action_mode: Mode of the values after them.
    """

    def __init__(self, arm_action_mode: ArmActionMode, gripper_action_mode: GripperActionMode) -> None:
        arm, gripper = example_call(arm_action_mode, ArmActionMode), example_call(gripper_action_mode, GripperActionMode)
        hint = f"Write `{type(self).__name__}({arm}, {gripper})`."
        self.arm_action_mode = checked_mode(arm_action_mode, "arm_action_mode", ArmActionMode, hint)
        self.gripper_action_mode = checked_mode(gripper_action_mode, "gripper_action_mode", GripperActionMode, hint)

    @property
    def optional_values(self) -> int:
        """Number of optional values of the arm mode."""
        return self.arm_action_mode.optional_values

    def spec(self, runtime: Runtime) -> ActionSpec:
        """Return the values of the arm, then those of the gripper."""
        return self.arm_action_mode.spec(runtime).joined(self.gripper_action_mode.spec(runtime))

    def shape(self, runtime: Runtime) -> tuple[int]:
        """Return the shape of an action, without optional values."""
        return (self.arm_action_mode.shape(runtime)[0] + self.gripper_action_mode.shape(runtime)[0],)

    def check(self, runtime: Runtime, values: FloatArray) -> FloatArray:
        """Return the values after the checks of both modes, or raise InvalidActionError if one of them rejects its values."""
        arm, gripper = self.split(runtime, values)
        arm, gripper = self.arm_action_mode.check(runtime, arm), self.gripper_action_mode.check(runtime, gripper)
        size = self.arm_action_mode.shape(runtime)[0]
        return np.concatenate([arm[:size], gripper, arm[size:]])

    def split(self, runtime: Runtime, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the values of the arm, optional ones last, and those of the gripper."""
        arm = self.arm_action_mode.shape(runtime)[0]
        both = arm + self.gripper_action_mode.shape(runtime)[0]
        return np.concatenate([values[:arm], values[both:]]), values[arm:both]


class MoveArmThenGripper(ActionMode):
    """Run the arm action to its end, then the gripper action. The end of the episode ends the action.

    With `EndEffectorPoseViaPlanning` an optional ninth value follows: 1 plans without collision checks, 0 with them.
    """

    def steps(self, runtime: Runtime, values: FloatArray) -> None:
        """Move the arm, then the gripper."""
        arm, gripper = self.split(runtime, values)
        self.arm_action_mode.run(runtime, arm)
        if runtime.over:
            return
        opening = self.gripper_action_mode.opening(runtime, gripper)
        refused = None if opening is None else self.arm_action_mode.refused_opening(runtime, opening)
        with self.arm_action_mode.protected(runtime):
            if refused is None:
                self.gripper_action_mode.run(runtime, gripper)
                return
            runtime.refuse_opening(refused)
            for _ in range(self.gripper_action_mode.ticks or 0):
                runtime.step()


KindOfMode = TypeVar("KindOfMode", bound=Mode)
_KINDS = {ArmActionMode: "an arm mode", GripperActionMode: "a gripper mode", ActionMode: "a whole action mode"}


def checked_mode(mode: object, what: str, kind: type[KindOfMode], hint: str) -> KindOfMode:
    """Return a mode of one kind.

    Raises:
        InvalidArgument: It is a class, a mode of another kind, or no mode; `hint` shows a correct call.
    """
    if isinstance(mode, kind):
        return mode
    if isinstance(mode, type):
        found = f", not the class {mode.__name__}"
    else:
        found = next((f", not {words}" for other, words in _KINDS.items() if isinstance(mode, other)), "")
    raise InvalidArgument(what, mode, f"has to be {_KINDS[kind]}{found}", hint)


def example_call(mode: object, kind: type[Mode]) -> str:
    """Return an example call that constructs a mode of one kind, of the given class if possible."""
    given = mode if isinstance(mode, type) else type(mode)
    if not issubclass(given, kind):
        given = JointVelocity if kind is ArmActionMode else Discrete
    return f"{given.__name__}()"


def as_action(action: object, size: int, what: str, more: int = 0) -> FloatArray:
    """Return `action` as a finite float64 vector of `size` or `size + more` values, or raise InvalidActionError."""
    try:
        array = as_array(action, what)
    except InvalidValue as error:
        raise InvalidActionError(f"{what} takes {size} numbers, not {shown(action)}. It {error.problem}.") from error
    if array.shape not in ((size,), (size + more,)):
        shapes = f"({size},)" if more == 0 else f"({size},) or ({size + more},)"
        raise InvalidActionError(f"{what} takes an array of shape {shapes}, not {array.shape}.", "wrong shape")
    if not all(map(math.isfinite, array.tolist())):
        bad = ", ".join(str(i) for i in np.flatnonzero(~np.isfinite(array)))
        raise InvalidActionError(f"{what} contains NaN or infinity at index {bad}. Check the output of the policy.", "not finite")
    return array.copy()


# Frames --------------------------------------------------------------------------------------------------------------


class RelativeFrame(IntEnum):
    """Frame of a Cartesian action."""

    WORLD = 0
    EE = 1


FrameChoice = RelativeFrame | Literal["world", "end effector"]
_FRAME_WORDS = {"world": RelativeFrame.WORLD, "end effector": RelativeFrame.EE}


def as_frame(frame: FrameChoice | int | str) -> RelativeFrame:
    """Return the frame for an enum value or its name."""
    if isinstance(frame, str):
        if frame not in _FRAME_WORDS:
            raise InvalidActionError(f"No relative frame is called '{frame}'. Use 'world' or 'end effector'.")
        return _FRAME_WORDS[frame]
    try:
        return RelativeFrame(frame)
    except (ValueError, TypeError, RuntimeError) as error:  # what cannot be compared
        raise InvalidActionError(f"No relative frame is {shown(frame)}. Use 'world' or 'end effector'.") from error


def assert_unit_quaternion(quaternion: FloatArray) -> None:
    """Raise InvalidActionError if the norm of a quaternion (4,) is not 1."""
    norm = float(np.linalg.norm(quaternion))
    if not np.isclose(norm, 1.0):
        raise InvalidActionError(
            f"The quaternion {np.round(quaternion, 4).tolist()} has norm {norm:.4f}. "
            "Divide it by its norm; the order is x, y, z, w.",
            "not a rotation",
        )


def calculate_delta_pose(current: FloatArray, action: FloatArray, frame: RelativeFrame = RelativeFrame.WORLD) -> FloatArray:
    """Apply a delta pose (7,) to the current tip pose (7,).

    In the world frame the position is added along world axes and the rotation multiplied from the left; in the end-effector
    frame the whole delta is composed on the right.
    """
    current, action = as_vector(current, 7, "current"), as_vector(action, 7, "action")
    if frame is RelativeFrame.EE:
        return compose(current, action)
    rotation = compose(np.concatenate([np.zeros(3), action[3:]]), np.concatenate([np.zeros(3), current[3:]]))
    return np.concatenate([current[:3] + action[:3], rotation[3:]])


class GripperMode(GripperActionMode):
    """Base class of the gripper modes of this package.

    Args:
        attach_grasped_objects: Fix graspable bodies between the fingers to the gripper; None uses the environment's setting.
        detach_before_open: Release bodies before the fingers open; otherwise afterwards.
    """

    def __init__(self, attach_grasped_objects: bool | None = None, detach_before_open: bool = True) -> None:
        if attach_grasped_objects is not None:
            attach_grasped_objects = as_flag(attach_grasped_objects, "attach_grasped_objects")
        self.attach_grasped_objects = attach_grasped_objects
        self.detach_before_open = as_flag(detach_before_open, "detach_before_open")

    def attaches(self, runtime: Runtime) -> bool:
        """Whether bodies are fixed to the gripper."""
        return runtime.gripper.attaches if self.attach_grasped_objects is None else self.attach_grasped_objects


def attaches_grasped(mode: object, default: bool) -> bool:
    """Return whether bodies are fixed to the gripper: the setting of the gripper mode, or `default` if it has none."""
    setting: bool | None = getattr(getattr(mode, "gripper_action_mode", None), "attach_grasped_objects", None)
    return default if setting is None else setting


class Discrete(GripperMode):
    """One value: above 0.5 opens the gripper, otherwise closes it. No effect if the gripper is already in this state.

    A value below 0 or above 1 raises InvalidActionError.
    """

    def spec(self, runtime: Runtime) -> ActionSpec:
        """Return one value from 0 (closed) to 1 (open)."""
        return ActionSpec(("gripper",), ("1",), np.zeros(1), np.ones(1), "joint", None)

    def shape(self, runtime: Runtime) -> tuple[int]:
        """One number."""
        return (1,)

    def check(self, runtime: Runtime, values: FloatArray) -> FloatArray:
        """Return the value, or raise InvalidActionError if it is not between 0 and 1."""
        if not 0.0 <= values[0] <= 1.0:
            raise InvalidActionError(
                f"The gripper action is {values[0]}; it must be between 0 (closed) and 1 (open). Clip the output of the policy.",
                "gripper out of range",
            )
        return values

    def opening(self, runtime: Runtime, values: FloatArray) -> FloatArray | None:
        """Return the positions of fully open fingers if the action opens the gripper."""
        if values[0] > 0.5 and not runtime.gripper.is_open:
            return np.full(2, runtime.description.gripper_open)
        return None

    def steps(self, runtime: Runtime, values: FloatArray) -> None:
        """Open or close the gripper if that changes its state."""
        wants_open = bool(values[0] > 0.5)
        if wants_open == runtime.gripper.is_open:
            return
        arm = runtime.description
        move_gripper(
            runtime,
            1.0 if wants_open else 0.0,
            release=wants_open,
            speed=arm.grip_speed if not wants_open and runtime.gripper.closes_on_something() else arm.finger_speed,
            attach=self.attaches(runtime),
            detach_before_open=self.detach_before_open,
        )


@dataclass
class FingerMove:
    """The finger motion of the present tick, from `pre_step` to `post_step`."""

    target: float | None = None
    """Commanded position of the fingers [m]."""
    opens: bool = False
    """Whether this opens the fingers."""


class GripperJointPosition(GripperMode):
    """One value: the position of both fingers [m], or its change, for one tick; then the fingers hold their position.

    Positions are clipped to the range of a finger.

    Args:
        attach_grasped_objects: Fix graspable bodies between the fingers when they cannot close further.
        detach_before_open: Release bodies before the fingers open; otherwise afterwards.
        absolute_mode: The value is a position; otherwise a difference to the measured position.
    """

    ticks = 1

    def __init__(
        self, attach_grasped_objects: bool | None = None, detach_before_open: bool = True, absolute_mode: bool = True
    ) -> None:
        super().__init__(attach_grasped_objects, detach_before_open)
        self.absolute_mode = as_flag(absolute_mode, "absolute_mode")

    def shape(self, runtime: Runtime) -> tuple[int]:
        """One number."""
        return (1,)

    def spec(self, runtime: Runtime) -> ActionSpec:
        """Return one value from 0 (closed) to the range of a finger; differences are between minus and plus this range."""
        high = np.array([runtime.description.gripper_open])
        return ActionSpec(("finger",), ("m",), np.zeros(1) if self.absolute_mode else -high, high, "joint", 1)

    def target(self, runtime: Runtime, values: FloatArray) -> tuple[float, bool]:
        """Return the target position of both fingers [m], and whether it opens the fingers."""
        here = runtime.robot.fingers.mean()
        target = float(np.clip(values[0] if self.absolute_mode else here + values[0], 0.0, runtime.description.gripper_open))
        return target, bool(target > here + 1e-4)

    def opening(self, runtime: Runtime, values: FloatArray) -> FloatArray | None:
        """Return the commanded positions if they open the fingers."""
        target, opens = self.target(runtime, values)
        return np.full(2, target) if opens else None

    def pre_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Command the finger motors without a simulation step; an opening command releases bodies."""
        target, opens = self.target(runtime, values)
        if opens and self.detach_before_open:
            runtime.gripper.release()
        if not runtime.gripper.grasped or opens:
            runtime.gripper.set_target(target / runtime.description.gripper_open, runtime.description.finger_speed)
        move = runtime.kept(self, FingerMove)
        move.target, move.opens = target, opens

    def steps(self, runtime: Runtime, values: FloatArray) -> None:
        """Run one tick in which the arm holds its position."""
        if runtime.robot.mode == "torque":
            runtime.hold()
        runtime.step()

    def post_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Attach the bodies that stopped the fingers, or release bodies; then hold the finger position.

        Raises:
            InvalidActionError: `pre_step` was not called before.
        """
        move = runtime.kept(self, FingerMove)
        target, move.target = move.target, None
        if target is None:
            raise InvalidActionError("`post_step` of the fingers was called without `pre_step`. Call `pre_step` first.")
        stalled = runtime.robot.fingers.mean() > target + 1e-3 and not runtime.gripper.moving
        hold_or_release(runtime, release=move.opens, attach=self.attaches(runtime) and stalled)
        runtime.gripper.hold()


DELTA_LIMIT = 0.1
"""Largest joint difference of `JointPositionActionMode` [rad]."""


class JointMode(ArmActionMode):
    """Base class of modes with one value per arm joint; subclasses override `bounds`.

    Args:
        absolute_mode: The values are absolute; otherwise they are differences to the measured values.
    """

    unit = ""
    ticks = 1

    def __init__(self, absolute_mode: bool = True) -> None:
        self.absolute_mode = as_flag(absolute_mode, "absolute_mode")

    def shape(self, runtime: Runtime) -> tuple[int]:
        """One number per arm joint."""
        return (runtime.model.size,)

    def spec(self, runtime: Runtime) -> ActionSpec:
        """One number per arm joint."""
        names = runtime.description.arm_joints
        low, high = self.bounds(runtime)
        return ActionSpec(names, (self.unit,) * len(names), low, high, "joint", 1)


class JointVelocity(JointMode):
    """Joint velocities [rad/s], or changes of the measured velocities, for one tick; then the arm stops.

    Velocities are clipped to the limits.
    """

    unit = "rad/s"

    def bounds(self, runtime: Runtime) -> tuple[FloatArray, FloatArray]:
        """Return the velocity limits of the joints."""
        limit = runtime.model.limits.velocity
        return -limit, limit

    def pre_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Set velocity targets."""
        runtime.robot.set_velocity_targets(values if self.absolute_mode else runtime.robot.joint_velocities + values)

    def post_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Command zero velocity."""
        runtime.robot.set_velocity_targets(np.zeros(runtime.model.size))


class JointPosition(JointMode):
    """Joint positions [rad], or changes of the measured positions: the arm moves towards them for one tick, then holds.

    Positions are clipped to the joint limits. The velocity limits bound the motion of one tick.
    """

    unit = "rad"

    def bounds(self, runtime: Runtime) -> tuple[FloatArray, FloatArray]:
        """Return the joint limits; for differences, the largest change in one tick at the velocity limits."""
        limits = runtime.model.limits
        if self.absolute_mode:
            return limits.lower, limits.upper
        step = limits.velocity * runtime.world.control_dt
        return -step, step

    def pre_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Set position targets."""
        runtime.robot.set_position_targets(values if self.absolute_mode else runtime.robot.joint_positions + values)

    def post_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Hold the measured positions."""
        runtime.hold()


class JointTorque(JointMode):
    """Joint torques [N m] for one tick, including gravity, or changes of the last motor torques; then the arm stops.

    Torques are clipped to the limits. Joint positions and velocities are not limited: torques can drive a joint past its stop.
    Limit them in the policy, or use another mode within `SafeArm`.
    Consecutive torque actions do not stop the arm. It brakes in ticks without a torque action, such as while the gripper moves.
    """

    unit = "N m"

    def bounds(self, runtime: Runtime) -> tuple[FloatArray, FloatArray]:
        """Return the effort limits of the joints."""
        limit = runtime.model.limits.effort
        return -limit, limit

    def pre_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Set torques."""
        runtime.robot.set_torques(values if self.absolute_mode else runtime.robot.joint_torques + values)

    def post_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Command zero velocity, so that no torque continues to act; the measured velocity does not change."""
        runtime.robot.set_velocity_targets(np.zeros(runtime.model.size))


class EndEffectorVelocity(ArmActionMode):
    """Tip velocity `[linear, angular]` (6,) for one tick, or a change of the present tip velocity; then the arm stops.

    Joint limits take precedence: if the velocity would violate one, the arm tracks it as closely as the limits allow.

    Args:
        absolute_mode: The values are a velocity; otherwise a difference to the present tip velocity.
        frame: Frame of the velocity: the world or the tip.
    """

    ticks = 1

    def __init__(self, absolute_mode: bool = True, frame: FrameChoice = RelativeFrame.WORLD) -> None:
        self.absolute_mode, self.frame = as_flag(absolute_mode, "absolute_mode"), as_frame(frame)

    def shape(self, runtime: Runtime) -> tuple[int]:
        """Six numbers."""
        return (6,)

    def spec(self, runtime: Runtime) -> ActionSpec:
        """Return the linear, then the angular velocity."""
        high = np.repeat([runtime.description.linear_speed, runtime.description.angular_speed], 3)
        return ActionSpec(TWIST_NAMES, TWIST_UNITS, -high, high, "end effector" if self.frame is RelativeFrame.EE else "world", 1)

    def pre_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Solve for joint velocities and command them."""
        axes: Literal["tip", "world"] = "tip" if self.frame is RelativeFrame.EE else "world"
        q, v = runtime.robot.joint_positions, runtime.robot.joint_velocities
        if not self.absolute_mode:
            values = values + runtime.model.jacobian(q, axes) @ v
        config = DifferentialIKConfig(dt=runtime.world.control_dt)
        solver = runtime.kept(self, lambda: DifferentialIK(runtime.model, config))
        runtime.robot.set_velocity_targets(solver.velocity_for_twist(q, v, values, axes))

    def post_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Command zero velocity."""
        runtime.robot.set_velocity_targets(np.zeros(runtime.model.size))


class JointPositionActionMode(ActionMode):
    """Joint differences [rad] and an absolute finger position [m], both within one control tick."""

    ticks = 1

    def __init__(self) -> None:
        super().__init__(JointPosition(absolute_mode=False), GripperJointPosition())

    def spec(self, runtime: Runtime) -> ActionSpec:
        """Return the values of both modes, with joint differences of at most 0.1 rad, for one tick."""
        spec = super().spec(runtime)
        low, high = spec.low.copy(), spec.high.copy()
        low[:-1], high[:-1] = -DELTA_LIMIT, DELTA_LIMIT
        return ActionSpec(spec.names, spec.units, low, high, spec.frame, 1)

    def pre_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Command the arm and the gripper."""
        self.arm_action_mode.pre_step(runtime, values[:-1])
        self.gripper_action_mode.pre_step(runtime, values[-1:])

    def post_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Hold the arm and the gripper."""
        self.arm_action_mode.post_step(runtime, values[:-1])
        self.gripper_action_mode.post_step(runtime, values[-1:])
