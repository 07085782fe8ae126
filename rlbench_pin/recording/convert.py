"""Convert a demonstration to another action mode, and verify that its actions still reach the goal.

`convert_demo` needs only the demonstration, and follows the motion of the arm model. Torques, and actions relative to measured
velocities, drift away from such a motion. `convert_by_playing` finds them by playing the demonstration again in the other mode.
It computes every action from the current measurement, so that errors of motors and contacts are corrected and do not add up. An
episode repeats exactly from its start, so the recorded actions have the same effect without feedback; `verify` plays them.

Torques are computed from the arm model, tick by tick. With the demonstrated next state (q_d, v_d) and measured (q, v),

    v_e = v_d + g (q_d - q - dt (v + v_d) / 2) / dt,    a = (v_e - v) / dt - b,    tau = M(q) a + h(q, v)             (1)

where g is the share of the position error that a tick removes, and b is the acceleration from loads that are not in the model.
After each tick, a share of (reached - expected velocity) / dt is added to b.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import pinocchio as pin

from rlbench_pin.control.differential_ik import DifferentialIK, DifferentialIKConfig
from rlbench_pin.environment.actions.modes import (
    ActionMode,
    EndEffectorVelocity,
    GripperJointPosition,
    JointPosition,
    JointTorque,
    JointVelocity,
    RelativeFrame,
)
from rlbench_pin.environment.actions.pose import ERJointViaIK, PoseMode
from rlbench_pin.environment.actions.safe_arm import unwrapped
from rlbench_pin.environment.demos import EXTRA_TICKS
from rlbench_pin.environment.replay import reaches_goal
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import DemoError, InvalidActionError, PlanningError
from rlbench_pin.observation import Demo
from rlbench_pin.planning.kinematics import descend, solve_ik
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_number, as_record

POSITION_SHARE = 0.5
"""g: share of the position error that a tick of torques removes."""
FIRST_CONFIGURATIONS = 8
"""Configurations of another arm from which its tip tries to follow."""
TICKS_SKIPPED = 5
"""Ticks at the begin of a demonstration that another arm leaves out at a time while it does not reach them."""
LARGEST_STEP = 0.5
"""Largest turn of a joint of another arm between two ticks of the demonstration [rad]; beyond it the arm would flip."""
SPEED_SHARE = 0.8
"""Share of the velocity limits at which another arm follows."""
LARGEST_SPEED = 1.0
"""Its joints are never faster than this [rad/s]."""
BIAS_SHARE = 0.5
"""Share of the unexplained acceleration of a tick that is taken as permanent."""


@dataclass(frozen=True, eq=False)
class _Moment:
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


def convert_demo(
    demo: Demo, action_mode: ActionMode, model: RobotModel, dt: float = 0.05, robot: RobotModel | None = None
) -> list[FloatArray]:
    """Return the actions of a demonstration in another action mode, one for every frame after the first.

    Velocities and their changes are found by following the motion of the arm model, so that rounding does not add up.

    Args:
        demo: A demonstration with joint positions and velocities, recorded live.
        action_mode: The mode to convert to.
        model: The arm that made the demonstration.
        dt: Its control tick [s].
        robot: Another arm for the actions, which starts at its home. It moves to the first tip pose that it reaches, before any
            motion of the gripper. Then its tip follows the tip of the demonstration. If a joint would be too fast, one tick
            becomes several.

    Raises:
        DemoError: The demonstration lacks data, or the tip of the other arm cannot follow.
        InvalidActionError: A demonstration cannot be converted to the mode.
    """
    as_record(action_mode, ActionMode, "action_mode")
    as_record(model, RobotModel, "model")
    dt = as_number(dt, "the control tick dt [s]", above=0.0)
    moments = _moments(demo)
    if robot is not None:
        moments, model = _followed(moments, model, as_record(robot, RobotModel, "robot"), dt), robot
    finger = _finger_conversion(action_mode, model)
    mode = unwrapped(action_mode.arm_action_mode)
    return [np.append(arm, finger(m)) for arm, m in zip(_arm_actions(mode, moments, model, dt), moments, strict=True)]


def _moments(demo: Demo) -> list[_Moment]:
    """Return the ticks of a demonstration.

    Raises:
        DemoError: It lacks joint positions, velocities or actions.
    """
    as_record(demo, Demo, "demo")
    moments: list[_Moment] = []
    amount = 1.0
    for before, after in zip(demo[:-1], demo[1:], strict=True):
        command = after.misc.get("joint_position_action")
        if before.joint_positions is None or before.joint_velocities is None or command is None:
            raise DemoError(
                "The demonstration lacks joint positions, joint velocities or actions. Record it live, with both switched on in "
                "the observations."
            )
        now = float(command[-1])
        target = np.asarray(command[:-1], dtype=float)
        moments.append(_Moment(before.joint_positions, before.joint_velocities, target, now, now != amount))
        amount = now
    return moments


def _followed(moments: Sequence[_Moment], model: RobotModel, robot: RobotModel, dt: float) -> list[_Moment]:
    """Return the moments of another arm whose tip follows the targets, from the first one that it reaches.

    Raises:
        DemoError: It cannot.
    """
    poses = [model.tip_se3(m.target) for m in moments]
    free = next((k for k, m in enumerate(moments) if m.gripper_moves), len(moments) - 1)
    reached = 0
    for first in range(0, free + 1, TICKS_SKIPPED):
        for start in _configurations(robot, poses[first]):
            path = [start]
            for pose in poses[first + 1 :]:
                descent = descend(robot, pose, path[-1])
                if not descent.converged or np.abs(descent.q - path[-1]).max() > LARGEST_STEP:
                    break
                path.append(descent.q)
            reached = max(reached, first + len(path))
            if first + len(path) == len(poses):
                return _timed(moments[first:], path, robot, dt)
    raise DemoError(
        f"The tip of '{robot.description.name}' follows the demonstration only to tick {reached} of {len(poses)}; "
        "the next pose is out of reach or near a singularity. Try another seed."
    )


def _configurations(robot: RobotModel, pose: pin.SE3) -> list[FloatArray]:
    """Return configurations that reach a pose, the nearest to home first; none where it is out of reach."""
    goal = np.append(pose.translation, pin.Quaternion(pose.rotation).coeffs())
    try:
        return solve_ik(robot, goal, robot.home, np.random.default_rng(0), starts=20, max_solutions=FIRST_CONFIGURATIONS)
    except PlanningError:
        return []


def _timed(moments: Sequence[_Moment], path: Sequence[FloatArray], robot: RobotModel, dt: float) -> list[_Moment]:
    """Return the moments of a path (ticks, n) from home, with as many ticks as the joints need."""
    q, v = robot.home, np.zeros(robot.size)
    largest = SPEED_SHARE * dt * np.minimum(robot.limits.velocity, LARGEST_SPEED)
    amount, timed = 1.0, list[_Moment]()
    for m, goal in zip(moments, path, strict=True):
        count = max(1, int(np.ceil(np.max(np.abs(goal - q) / largest))))
        begin = q
        for k in range(1, count + 1):
            target = begin + (goal - begin) * k / count
            amount, moves = (m.amount, m.gripper_moves) if k == count else (amount, False)
            timed.append(_Moment(q, v, target, amount, moves))
            q, v = target, np.zeros(robot.size) if moves else (target - q) / dt
    return timed


def _arm_actions(mode: object, moments: Sequence[_Moment], model: RobotModel, dt: float) -> Iterator[FloatArray]:
    if isinstance(mode, JointTorque) and mode.absolute_mode:
        return (model.inverse_dynamics(m.q, m.v, ((m.target - m.q) / dt - m.v) / dt) for m in moments)
    if isinstance(mode, JointVelocity | EndEffectorVelocity):
        return _followed_velocities(mode, moments, model, dt)
    return (_arm_action(mode, m, model, dt) for m in moments)


def _followed_velocities(
    mode: JointVelocity | EndEffectorVelocity, moments: Sequence[_Moment], model: RobotModel, dt: float
) -> Iterator[FloatArray]:
    """Yield the actions of an arm model that follows the targets."""
    solver = DifferentialIK(model, DifferentialIKConfig(dt=dt))
    q, v = moments[0].q.copy(), np.zeros_like(moments[0].q)
    for m in moments:
        here = replace(m, q=q, v=v)
        velocity = _velocity(mode, here, model, dt)
        yield _velocity_action(mode, here, velocity, model)
        if isinstance(mode, EndEffectorVelocity):
            velocity = solver.velocity_for_twist(q, v, velocity, _axes(mode))
        q = q + dt * velocity
        v = np.zeros_like(v) if m.gripper_moves else velocity


def _arm_action(mode: object, m: _Moment, model: RobotModel, dt: float) -> FloatArray:
    """Return the action of an arm mode that brings the arm from a moment to its target.

    Raises:
        InvalidActionError: The mode cannot express a demonstration, or not from a single moment.
    """
    if isinstance(mode, JointPosition):
        return m.target if mode.absolute_mode else m.target - m.q
    if isinstance(mode, JointVelocity | EndEffectorVelocity):
        return _velocity_action(mode, m, _velocity(mode, m, model, dt), model)
    if isinstance(mode, PoseMode) and not isinstance(mode, ERJointViaIK):
        return mode.action_to(model.tip_pose(m.target), model.tip_pose(m.q))
    raise InvalidActionError(
        f"A demonstration cannot be converted to actions of {type(mode).__name__}. Use JointPosition, JointVelocity, "
        "EndEffectorVelocity or EndEffectorPoseViaIK; `convert_by_playing` also converts to JointTorque."
    )


def _velocity(mode: JointVelocity | EndEffectorVelocity, m: _Moment, model: RobotModel, dt: float) -> FloatArray:
    """Return the velocity of joints [rad/s] or tip [m/s, rad/s] that brings the arm to the target of a moment in `dt`."""
    if isinstance(mode, JointVelocity):
        return (m.target - m.q) / dt
    here, goal = model.tip_se3(m.q), model.tip_se3(m.target)
    twist = np.concatenate([goal.translation - here.translation, pin.log3(goal.rotation @ here.rotation.T)]) / dt
    if _axes(mode) == "world":
        return twist
    return np.concatenate([here.rotation.T @ twist[:3], here.rotation.T @ twist[3:]])


def _velocity_action(
    mode: JointVelocity | EndEffectorVelocity, m: _Moment, velocity: FloatArray, model: RobotModel
) -> FloatArray:
    """Return a velocity, or its difference to that of the moment."""
    if mode.absolute_mode:
        return velocity
    return velocity - (m.v if isinstance(mode, JointVelocity) else model.jacobian(m.q, _axes(mode)) @ m.v)


def _axes(mode: EndEffectorVelocity) -> Literal["tip", "world"]:
    return "tip" if mode.frame is RelativeFrame.EE else "world"


def _finger_conversion(action_mode: ActionMode, model: RobotModel) -> Callable[[_Moment], float]:
    """Return the function from a moment to the last number of an action, for the gripper.

    Raises:
        InvalidActionError: The mode moves fingers by differences.
    """
    gripper = action_mode.gripper_action_mode
    if isinstance(gripper, GripperJointPosition):
        if not gripper.absolute_mode:
            raise InvalidActionError(
                "A demonstration has absolute finger positions, not changes. Use GripperJointPosition(absolute_mode=True)."
            )
        return lambda m: m.amount * model.description.gripper_open
    return lambda m: m.amount


def verify(task: TaskEnvironment, demo: Demo, actions: Sequence[FloatArray]) -> bool:
    """Return whether `actions` reach the goal from the start of `demo`; a refused action is a failure.

    Args:
        task: The environment of the demonstration's task, with the action mode of the actions.
        demo: Demonstration with the start state.
        actions: Actions, such as those of `convert_demo`.
    """
    as_record(task, TaskEnvironment, "task")
    task.reset_to_demo(demo)
    try:
        return reaches_goal(task, [*actions, *[_waiting_action(task, actions[-1])] * EXTRA_TICKS])
    except InvalidActionError:
        return False


def _waiting_action(task: TaskEnvironment, last: FloatArray) -> FloatArray:
    """Return the action that waits: the last one where it is absolute, otherwise no motion with the same gripper command."""
    mode = unwrapped(task.action_mode.arm_action_mode)
    if isinstance(mode, JointTorque | JointPosition) and mode.absolute_mode:
        return last
    if isinstance(mode, PoseMode):
        return last if not mode.is_relative else np.append([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], last[7:])
    return np.append(np.zeros(len(last) - 1), last[-1:])


def convert_by_playing(task: TaskEnvironment, demo: Demo) -> list[FloatArray]:
    """Return the actions of a demonstration in the action mode of `task`, one for every frame after the first until success.

    Args:
        task: The environment of the demonstration's task, in the mode to convert to. It is reset, and is left in the last state.
        demo: A demonstration with joint positions and velocities, recorded live.

    Raises:
        DemoError: The demonstration lacks data.
        InvalidActionError: A demonstration cannot be converted to the mode, or an action was refused.
    """
    as_record(task, TaskEnvironment, "task")
    moments, runtime = _moments(demo), task.runtime
    mode = unwrapped(task.action_mode.arm_action_mode)
    torques = _Torques(runtime, mode.absolute_mode) if isinstance(mode, JointTorque) else None
    finger = _finger_conversion(task.action_mode, runtime.model)
    ends = [m.v for m in moments[1:]] + [np.zeros(runtime.model.size)]
    task.reset_to_demo(demo)
    actions: list[FloatArray] = []
    for m, end in zip(moments, ends, strict=True):
        now = replace(m, q=runtime.robot.joint_positions, v=runtime.robot.joint_velocities)
        arm = torques(now, end) if torques else _arm_action(mode, now, runtime.model, runtime.world.control_dt)
        actions.append(np.append(arm, finger(m)))
        if task.step(actions[-1])[2]:
            break
    return actions


class _Torques:
    """Equation (1)."""

    def __init__(self, runtime: Runtime, absolute: bool) -> None:
        self._runtime, self._absolute, self._dt = runtime, absolute, runtime.world.control_dt
        self._bias = np.zeros(runtime.model.size)
        self._expected: FloatArray | None = None

    def __call__(self, m: _Moment, end: FloatArray) -> FloatArray:
        """Return the torques (n,) [N m] of a tick, or what they add to those of the last."""
        dt, model = self._dt, self._runtime.model
        if self._expected is not None:
            self._bias += BIAS_SHARE * (m.v - self._expected) / dt
        wanted = end + POSITION_SHARE * ((m.target - m.q) / dt - 0.5 * (m.v + end))
        torque = model.inverse_dynamics(m.q, m.v, (wanted - m.v) / dt - self._bias)
        torque = np.clip(torque, -model.limits.effort, model.limits.effort)
        self._expected = None if m.gripper_moves else wanted
        return torque if self._absolute else torque - self._runtime.robot.joint_torques
