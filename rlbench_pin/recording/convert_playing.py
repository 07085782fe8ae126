"""A demonstration in another action space, found by playing it once more in that space.

Every action is worked out from what is measured just before it, so that errors of motors and contacts are corrected on
the way instead of adding up. Since an episode is repeated exactly from its start, the recorded actions alone have the
same effect again: `verify` plays them without feedback. This takes the environment, not only the demonstration.

Torques are computed from the arm model, tick by tick. With the demonstrated next state (q_d, v_d) and measured (q, v),

    v_e = v_d + g (q_d - q - dt (v + v_d) / 2) / dt,    a = (v_e - v) / dt - b,    tau = M(q) a + h(q, v)             (1)

where g is the share of the position error removed in a tick, and b is what loads that the model does not know added to the
acceleration so far: after each tick, a share of (reached - expected velocity) / dt is added to it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np

from rlbench_pin.environment.actions.joint import EndEffectorVelocity, JointPosition, JointTorque, JointVelocity
from rlbench_pin.environment.actions.mode import RelativeFrame
from rlbench_pin.environment.actions.pose import ERJointViaIK, PoseMode
from rlbench_pin.environment.actions.safe_arm import unwrapped
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import InvalidActionError
from rlbench_pin.observation import Demo
from rlbench_pin.recording.convert import Moment, demo_moments, finger_conversion, tip_pose_action, tip_twist
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_record

POSITION_SHARE = 0.5
"""g: share of the position error that a tick of torques removes."""
BIAS_SHARE = 0.5
"""Share of the unexplained acceleration of a tick that is taken as lasting."""

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
        actions.append(np.append(play(Moment(q, v, m.target, m.amount, m.hand_moves), end), finger(m)))
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
        self._expected = None if m.hand_moves else wanted
        return torque if self._absolute else torque - self._runtime.robot.joint_torques


__all__ = ["convert_by_playing"]
