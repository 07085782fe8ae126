"""A demonstration in another action mode, and whether its actions still reach the goal.

`convert_demo` needs only the demonstration and follows the motion of the arm model. Actions relative to measured velocities, and
torques, drift away from such a motion; `convert_by_playing` finds them by playing the demonstration again in the other mode. It
computes every action from what is measured just before it, so that errors of motors and contacts are corrected instead of adding
up. Since an episode repeats exactly from its start, the recorded actions have the same effect without feedback:
`verify` plays them.

Torques are computed from the arm model, tick by tick. With the demonstrated next state (q_d, v_d) and measured (q, v),

    v_e = v_d + g (q_d - q - dt (v + v_d) / 2) / dt,    a = (v_e - v) / dt - b,    tau = M(q) a + h(q, v)             (1)

where g is the share of the position error removed in a tick, and b is what loads that the model does not know added to the
acceleration so far: after each tick, a share of (reached - expected velocity) / dt is added to it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pinocchio as pin

from rlbench_pin.control.differential_ik import DifferentialIK, DifferentialIKConfig
from rlbench_pin.environment.actions.action_mode import ActionMode
from rlbench_pin.environment.actions.arm_mode import RelativeFrame
from rlbench_pin.environment.actions.gripper import GripperJointPosition
from rlbench_pin.environment.actions.joint import JointPosition, JointTorque, JointVelocity
from rlbench_pin.environment.actions.pose import ERJointViaIK, PoseMode
from rlbench_pin.environment.actions.safe_arm import unwrapped
from rlbench_pin.environment.actions.twist import EndEffectorVelocity
from rlbench_pin.environment.demonstrate import EXTRA_TICKS
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import DemoError, InvalidActionError
from rlbench_pin.observation import Demo
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray, compose, inverse, relative
from rlbench_pin.values import as_number, as_record


@dataclass(frozen=True, eq=False)
class Moment:
    """One tick of a demonstration."""

    q: FloatArray
    """Joint positions at its start [rad]."""
    v: FloatArray
    """Joint velocities at its start [rad/s]."""
    target: FloatArray
    """Commanded joint positions at its end [rad]."""
    amount: float
    """Commanded opening fraction of the gripper."""
    gripper_moves: bool
    """Whether the gripper moves after the tick, so that the arm comes to rest."""


def convert_demo(demo: Demo, action_mode: ActionMode, model: RobotModel, dt: float = 0.05) -> list[FloatArray]:
    """Return the actions of a demonstration in another action mode, one for every frame after the first.

    Velocities and their changes are found by following the motion of the arm model, so that rounding does not add up.

    Args:
        demo: A demonstration with joint positions and velocities, recorded live.
        action_mode: The mode to convert to.
        model: The arm that made the demonstration.
        dt: Its control tick [s].

    Raises:
        DemoError: The demonstration lacks what the conversion needs.
        InvalidActionError: The mode cannot express a demonstration.
    """
    as_record(action_mode, ActionMode, "action_mode")
    as_record(model, RobotModel, "model")
    dt = as_number(dt, "the control tick dt [s]", above=0.0)
    moments = demo_moments(demo)
    finger = finger_conversion(action_mode, model)
    mode = unwrapped(action_mode.arm_action_mode)
    return [np.append(arm, finger(m)) for arm, m in zip(_arm_actions(mode, moments, model, dt), moments, strict=True)]


def demo_moments(demo: Demo) -> list[Moment]:
    """Return the ticks of a demonstration.

    Raises:
        DemoError: It lacks joint positions, velocities or actions.
    """
    as_record(demo, Demo, "demo")
    moments: list[Moment] = []
    amount = 1.0
    for before, after in zip(demo[:-1], demo[1:], strict=True):
        command = after.misc.get("joint_position_action")
        if before.joint_positions is None or before.joint_velocities is None or command is None:
            raise DemoError(
                "The demonstration lacks joint positions, velocities or actions. Record it live with both switched on."
            )
        now = float(command[-1])
        target = np.asarray(command[:-1], dtype=float)
        moments.append(Moment(before.joint_positions, before.joint_velocities, target, now, now != amount))
        amount = now
    return moments


def _arm_actions(mode: object, moments: Sequence[Moment], model: RobotModel, dt: float) -> Iterator[FloatArray]:
    if isinstance(mode, JointPosition):
        return (m.target if mode.absolute_mode else m.target - m.q for m in moments)
    if isinstance(mode, JointVelocity):
        return _joint_velocities(mode, moments, dt)
    if isinstance(mode, JointTorque) and mode.absolute_mode:
        return (model.inverse_dynamics(m.q, m.v, ((m.target - m.q) / dt - m.v) / dt) for m in moments)
    if isinstance(mode, EndEffectorVelocity):
        return _tip_velocities(mode, moments, model, dt)
    if isinstance(mode, PoseMode) and not isinstance(mode, ERJointViaIK):
        return (tip_pose_action(m, mode, model) for m in moments)
    raise InvalidActionError(f"A demonstration cannot be written as actions of {type(mode).__name__}.")


def _joint_velocities(mode: JointVelocity, moments: Sequence[Moment], dt: float) -> Iterator[FloatArray]:
    """Yield velocities that follow the targets, or their changes from tick to tick."""
    q, v = moments[0].q.copy(), np.zeros_like(moments[0].q)
    for m in moments:
        wanted = (m.target - q) / dt
        yield wanted if mode.absolute_mode else wanted - v
        q = q + dt * wanted
        v = np.zeros_like(v) if m.gripper_moves else wanted


def _tip_velocities(mode: EndEffectorVelocity, moments: Sequence[Moment], model: RobotModel, dt: float) -> Iterator[FloatArray]:
    """Yield tip velocities whose ticks end at the targets: translation and rotation vector over dt."""
    solver = DifferentialIK(model, DifferentialIKConfig(dt=dt))
    in_tip = mode.frame is RelativeFrame.EE
    axes: Literal["tip", "world"] = "tip" if in_tip else "world"
    q, v = moments[0].q.copy(), np.zeros_like(moments[0].q)
    for m in moments:
        here, goal = model.tip_se3(q), model.tip_se3(m.target)
        twist = tip_twist(here, goal, in_tip, dt)
        yield twist if mode.absolute_mode else twist - model.jacobian(q, axes) @ v
        joint_velocity = solver.velocity_for_twist(q, v, twist, axes)
        q = q + dt * joint_velocity
        v = np.zeros_like(v) if m.gripper_moves else joint_velocity


def tip_twist(here: pin.SE3, goal: pin.SE3, in_tip: bool, dt: float) -> FloatArray:
    """Return the velocity (6,), [m/s, rad/s], that brings the tip from `here` to `goal` in `dt`, along world or tip axes."""
    twist = np.concatenate([goal.translation - here.translation, pin.log3(goal.rotation @ here.rotation.T)]) / dt
    if not in_tip:
        return twist
    return np.concatenate([here.rotation.T @ twist[:3], here.rotation.T @ twist[3:]])


def tip_pose_action(m: Moment, mode: PoseMode, model: RobotModel) -> FloatArray:
    """Return the pose, or its difference to the tip's, that a moment leads to, as `mode` has it, shape (7,)."""
    goal, here = model.tip_pose(m.target), model.tip_pose(m.q)
    if mode.frame is RelativeFrame.EE:
        return relative(goal, here)
    if mode.absolute_mode:
        return goal
    rotation = compose(np.append(np.zeros(3), goal[3:]), inverse(np.append(np.zeros(3), here[3:])))
    return np.append(goal[:3] - here[:3], rotation[3:])


def finger_conversion(action_mode: ActionMode, model: RobotModel) -> Callable[[Moment], float]:
    """Return the function from a moment to the last number of an action, for the gripper.

    Raises:
        InvalidActionError: The mode moves fingers by differences.
    """
    gripper = action_mode.gripper_action_mode
    if isinstance(gripper, GripperJointPosition):
        if not gripper.absolute_mode:
            raise InvalidActionError("A demonstration says where the fingers go, not by how much; use absolute finger positions.")
        return lambda m: m.amount * model.description.gripper_open
    return lambda m: m.amount


def verify(task: TaskEnvironment, demo: Demo, actions: Sequence[FloatArray]) -> bool:
    """Whether `actions` reach the goal from the start of `demo`; refused actions count as failure.

    Args:
        task: The environment of the demonstration's task, whose action mode the actions are for.
        demo: Gives the start.
        actions: As from `convert_demo`.
    """
    as_record(task, TaskEnvironment, "task")
    task.reset_to_demo(demo)
    for action in (*actions, *[_waiting_action(task, actions[-1])] * EXTRA_TICKS):
        try:
            _, reward, terminate = task.step(action)
        except InvalidActionError:
            return False
        if terminate or reward > 0.0:
            return reward > 0.0
    return False


def _waiting_action(task: TaskEnvironment, last: FloatArray) -> FloatArray:
    """Return the action that waits: the last one where it is absolute, otherwise no motion with the same gripper command."""
    mode = unwrapped(task.action_mode.arm_action_mode)
    if isinstance(mode, JointTorque) or (isinstance(mode, JointPosition) and mode.absolute_mode):
        return last
    if isinstance(mode, PoseMode):
        return last if not mode.is_relative else np.append([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], last[7:])
    return np.append(np.zeros(len(last) - 1), last[-1:])


POSITION_SHARE = 0.5
"""g: share of the position error that a tick of torques removes."""
BIAS_SHARE = 0.5
"""Share of the unexplained acceleration of a tick that is taken as permanent."""

Play = Callable[[Moment, FloatArray], FloatArray]
"""From a moment with measured q and v, and the demonstrated velocity at its end (n,), to an arm action."""


def convert_by_playing(task: TaskEnvironment, demo: Demo) -> list[FloatArray]:
    """Return the actions of a demonstration in the action mode of `task`, one for every frame after the first until success.

    Args:
        task: The environment of the demonstration's task, in the mode to convert to; it is reset, and left at the end.
        demo: A demonstration with joint positions and velocities, recorded live.

    Raises:
        DemoError: The demonstration lacks what the conversion needs.
        InvalidActionError: The mode cannot express a demonstration, or refused an action.
    """
    as_record(task, TaskEnvironment, "task")
    moments, runtime = demo_moments(demo), task.runtime
    play = _player(task)
    finger = finger_conversion(task.action_mode, runtime.model)
    ends = [m.v for m in moments[1:]] + [np.zeros(runtime.model.size)]
    task.reset_to_demo(demo)
    actions: list[FloatArray] = []
    for m, end in zip(moments, ends, strict=True):
        q, v = runtime.robot.joint_positions, runtime.robot.joint_velocities
        actions.append(np.append(play(Moment(q, v, m.target, m.amount, m.gripper_moves), end), finger(m)))
        if task.step(actions[-1])[2]:
            break
    return actions


def _player(task: TaskEnvironment) -> Play:
    """Return the function that computes actions of the arm mode."""
    runtime = task.runtime
    mode = unwrapped(task.action_mode.arm_action_mode)
    model, dt = runtime.model, runtime.world.control_dt
    if isinstance(mode, JointPosition):
        return lambda m, end: m.target if mode.absolute_mode else m.target - m.q
    if isinstance(mode, JointVelocity):
        return lambda m, end: (m.target - m.q) / dt - (0.0 if mode.absolute_mode else m.v)
    if isinstance(mode, JointTorque):
        return _Torques(runtime, mode.absolute_mode)
    if isinstance(mode, EndEffectorVelocity):
        in_tip = mode.frame is RelativeFrame.EE
        axes: Literal["tip", "world"] = "tip" if in_tip else "world"

        def twist(m: Moment, end: FloatArray) -> FloatArray:
            velocity = tip_twist(model.tip_se3(m.q), model.tip_se3(m.target), in_tip, dt)
            return velocity if mode.absolute_mode else velocity - model.jacobian(m.q, axes) @ m.v

        return twist
    if isinstance(mode, PoseMode) and not isinstance(mode, ERJointViaIK):
        return lambda m, end: tip_pose_action(m, mode, model)
    raise InvalidActionError(f"A demonstration cannot be played as actions of {type(mode).__name__}.")


class _Torques:
    """Equation (1)."""

    def __init__(self, runtime: Runtime, absolute: bool) -> None:
        self._runtime, self._absolute, self._dt = runtime, absolute, runtime.world.control_dt
        self._bias = np.zeros(runtime.model.size)
        self._expected: FloatArray | None = None

    def __call__(self, m: Moment, end: FloatArray) -> FloatArray:
        """Return the torques (n,) [N m] of a tick, or what they add to those of the last."""
        dt, model = self._dt, self._runtime.model
        if self._expected is not None:
            self._bias += BIAS_SHARE * (m.v - self._expected) / dt
        wanted = end + POSITION_SHARE * ((m.target - m.q) / dt - 0.5 * (m.v + end))
        torque = model.inverse_dynamics(m.q, m.v, (wanted - m.v) / dt - self._bias)
        torque = np.clip(torque, -model.limits.effort, model.limits.effort)
        self._expected = None if m.gripper_moves else wanted
        return torque if self._absolute else torque - self._runtime.robot.joint_torques
