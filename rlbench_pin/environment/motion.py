"""Running a planned motion and operating the gripper, tick by tick; shared by action modes and demonstrations."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rlbench_pin.control.following import TrajectoryTracker
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.robot.trajectory import Trajectory
from rlbench_pin.spatial import FloatArray

LEAST_SPEED = 0.13
"""Joint speed in the first and in the last tick of a motion [rad/s]: a moving arm is never taken for a resting one, whose speed
by the rule of key frames is below 0.1."""
REST_SPEED = 0.05
"""Joint speed below which the arm counts as resting [rad/s]."""
_REST_TICKS = 10
"""Control ticks that the arm may take to come to rest after a motion."""
_GRIPPER_TICKS = 60
"""Control ticks that the fingers move at most."""
_SETTLE_TICKS_AFTER_OPENING = 10
"""Control ticks for what was let go to come to rest."""
_LASTING = 1.0
"""For how long a success has to last to be a lasting one [s]."""


def follow(
    runtime: Runtime,
    trajectory: Trajectory,
    *,
    on_tick: Callable[[FloatArray], None] = lambda target: None,
    whole: bool = False,
) -> None:
    """Track `trajectory` to its end and come to rest there, or until the episode is over.

    Args:
        runtime: What moves.
        trajectory: Timed joint motion that starts where the arm is.
        on_tick: Called after every tick with the commanded joint positions (n,) [rad].
        whole: Go on when the episode is over.
    """
    target = runtime.robot.joint_positions
    for target in TrajectoryTracker(trajectory, runtime.world.control_dt, LEAST_SPEED):
        runtime.drive_to(target)
        on_tick(target)
        if runtime.over and not whole:
            return
    for _ in range(_REST_TICKS):
        if (runtime.over and not whole) or np.abs(runtime.robot.joint_velocities).max() < REST_SPEED:
            return
        runtime.drive_to(target)
        on_tick(target)


def move_gripper(
    runtime: Runtime,
    amount: float,
    *,
    release: bool,
    speed: float,
    attach: bool = True,
    detach_before_open: bool = True,
    on_tick: Callable[[], None] = lambda: None,
) -> None:
    """Drive the fingers to an opening fraction and attach or release bodies. Ends early where the episode is over.

    Closing runs by physics until the fingers stall; then every registered graspable body between them that both touch is fixed to
    the gripper.

    Args:
        runtime: What moves.
        amount: Opening fraction, 0 shut to 1 open.
        release: Let go of what is held (an opening motion); otherwise hold what lies between the fingers afterwards.
        speed: Finger speed [m/s].
        attach: Fix bodies to the gripper; otherwise friction alone holds them.
        detach_before_open: Release before the fingers move; otherwise after.
        on_tick: Called after every tick.
    """
    if runtime.robot.mode == "torque":
        runtime.hold()
    if release and detach_before_open:
        runtime.gripper.release()
    runtime.gripper.set_target(amount, speed)
    for tick in range(_GRIPPER_TICKS):
        runtime.step()
        on_tick()
        if runtime.over or (tick > 0 and not runtime.gripper.moving):
            break
    hold_or_release(runtime, release=release, attach=attach)
    for _ in range(_SETTLE_TICKS_AFTER_OPENING if release else 0):
        if runtime.over:
            return
        runtime.step()
        on_tick()


def hold_or_release(runtime: Runtime, *, release: bool, attach: bool) -> None:
    """Let everything go, or fix every graspable body that both fingers touch to the gripper."""
    if release:
        runtime.gripper.release()
    elif attach:
        for name in runtime.gripper.between_fingers():
            runtime.gripper.grasp(name)


def success_lasts(runtime: Runtime) -> bool:
    """Whether the goal is reached now and still is 1 s later, the arm stationary, the gripper as it is.

    Afterwards everything is as it was (measured torques from the next tick on); observers and callbacks notice nothing.
    """
    before, task = runtime.save(), runtime.task
    reached = bool(task.success()[0])
    if reached:
        runtime.hold()
        runtime.gripper.hold()
        for _ in range(round(_LASTING / runtime.world.control_dt)):
            runtime.world.step()
            task.step()
        reached = bool(task.success()[0])
    runtime.restore(before)
    return reached
