"""One demonstration in any action space, and the proof that it still works there.

`convert_demo` needs the demonstration alone and follows the motion of the arm model. What is relative to measured
velocities, and torques, drift away from such a motion; `convert_playing` finds them by playing the demonstration again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pinocchio as pin

from rlbench_pin.control.differential_ik import DifferentialIK, DifferentialIKConfig
from rlbench_pin.environment.actions.gripper import GripperJointPosition
from rlbench_pin.environment.actions.joint import EndEffectorVelocity, JointPosition, JointTorque, JointVelocity
from rlbench_pin.environment.actions.mode import ActionMode, RelativeFrame
from rlbench_pin.environment.actions.pose import ERJointViaIK, PoseMode
from rlbench_pin.environment.actions.safe_arm import unwrapped
from rlbench_pin.environment.demos import EXTRA_TICKS
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
    """Commanded opening fraction of the hand."""
    hand_moves: bool
    """Whether the hand moves after the tick, so that the arm comes to rest."""


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
    """Velocities that follow the targets, or their changes from tick to tick."""
    q, v = moments[0].q.copy(), np.zeros_like(moments[0].q)
    for m in moments:
        wanted = (m.target - q) / dt
        yield wanted if mode.absolute_mode else wanted - v
        q = q + dt * wanted
        v = np.zeros_like(v) if m.hand_moves else wanted


def _tip_velocities(mode: EndEffectorVelocity, moments: Sequence[Moment], model: RobotModel, dt: float) -> Iterator[FloatArray]:
    """Tip velocities whose ticks end at the targets: the shift and the rotation vector over dt."""
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
        v = np.zeros_like(v) if m.hand_moves else joint_velocity


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
    turn = compose(np.append(np.zeros(3), goal[3:]), inverse(np.append(np.zeros(3), here[3:])))
    return np.append(goal[:3] - here[:3], turn[3:])


def finger_conversion(action_mode: ActionMode, model: RobotModel) -> Callable[[Moment], float]:
    """Return what turns the hand of a moment into the last number of an action.

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
    for action in (*actions, *[_rest(task, actions[-1])] * EXTRA_TICKS):
        try:
            _, reward, terminate = task.step(action)
        except InvalidActionError:
            return False
        if terminate or reward > 0.0:
            return reward > 0.0
    return False


def _rest(task: TaskEnvironment, last: FloatArray) -> FloatArray:
    """Return the action that waits: the last one where it names a place, otherwise no motion with the same hand."""
    mode = unwrapped(task.action_mode.arm_action_mode)
    if isinstance(mode, JointTorque) or (isinstance(mode, JointPosition) and mode.absolute_mode):
        return last
    if isinstance(mode, PoseMode):
        return last if not mode.is_relative else np.append([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], last[7:])
    return np.append(np.zeros(len(last) - 1), last[-1:])


__all__ = ["convert_demo", "verify"]
