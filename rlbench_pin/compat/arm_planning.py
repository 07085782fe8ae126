"""Kinematics and planning for the arms of `pyrep`, in the current world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pyrep.objects import Object
from pyrep.objects.object import euler_to_quaternion
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.planning import Algorithm, MotionPlanner, Plan, retime, solve_ik
from rlbench_pin.planning.timing import ArcLimits
from rlbench_pin.robot.trajectory import Trajectory
from rlbench_pin.spatial import FloatArray, compose

ALGORITHMS: dict[str, Algorithm] = {
    "RRT": "rrt",
    "RRTstar": "rrt_star",
    "BITstar": "bit_star",
    "KPIECE1": "kpiece",
    "BKPIECE1": "bkpiece",
    "LBKPIECE1": "lbkpiece",
}
"""PyRep's name of an algorithm -> our name; all other names select RRT-Connect."""
USUAL_JERK = 1000.0
"""From this jerk limit on, trajectories have no jerk limit [rad/s^3]."""


@dataclass(frozen=True)
class Pace:
    """Limits of velocity, acceleration and jerk of an arm."""

    velocity: float
    """Maximum velocity [rad/s]."""
    acceleration: float
    """Maximum acceleration [rad/s^2]."""
    jerk: float
    """Maximum jerk [rad/s^3]."""


def world_pose(
    position: Sequence[float] | FloatArray,
    euler: Sequence[float] | FloatArray | None,
    quaternion: Sequence[float] | FloatArray | None,
    relative_to: Object | None = None,
) -> FloatArray:
    """Return a pose (7,) in the world.

    Args:
        position: Position (3,) [m].
        euler: Intrinsic rotations (3,) about x, y, z [rad]; either this or the quaternion is given.
        quaternion: Quaternion (4,): x, y, z, w.
        relative_to: Object in whose frame the pose is given; None is the world.

    Raises:
        ValueError: Not exactly one of `euler` and `quaternion` is given, or a number is missing or not finite.
    """
    if (euler is None) == (quaternion is None):
        raise ValueError("Pass either `euler` (3 angles) or `quaternion` (x, y, z, w), but not both.")
    rotation = euler_to_quaternion(euler) if euler is not None else np.asarray(quaternion, dtype=float)
    pose = np.concatenate([np.asarray(position, dtype=float).reshape(-1), rotation.reshape(-1)])
    if pose.shape != (7,) or not np.isfinite(pose).all() or not np.any(rotation):
        raise ValueError(f"A pose has to be 3 finite numbers for the position and 3 or 4 for the rotation, not {pose.tolist()}.")
    return compose(pose) if relative_to is None else compose(np.asarray(relative_to.get_pose(), dtype=float), pose)


def plan_to(
    simulator: Simulator, pose: FloatArray, *, straight: bool | None, ignore_collisions: bool, algorithm: str = ""
) -> Plan:
    """Plan from the current configuration to a tip pose (7,); see `MotionPlanner.plan_to_pose`.

    Args:
        simulator: The simulator of the arm.
        pose: Target pose of the tip in the world (7,).
        straight: True: only a straight line; False: no straight line; None: a straight line first.
        ignore_collisions: Plan without collision checks; otherwise the bodies of `may_be_touched` are ignored.
        algorithm: PyRep's name of a sampling planner.
    """
    runtime = simulator.runtime
    planner = _planner(runtime, algorithm)
    planner.update(runtime.world.snapshot())
    allowed = () if ignore_collisions else may_be_touched(simulator)
    q, rng = runtime.measured_start, runtime.planning_rng
    return planner.plan_to_pose(q, pose, straight=straight, ignore_collisions=ignore_collisions, allowed=allowed, rng=rng)


def may_be_touched(simulator: Simulator) -> tuple[str, ...]:
    """Return the names of the bodies that plans ignore: those that the arm touches now, and those that are not collidable."""
    return tuple(sorted({*uncollidable(simulator), *simulator.runtime.touching()}))


def uncollidable(simulator: Simulator) -> list[str]:
    """Return the names of the bodies that a program made not collidable."""
    flags = simulator.objects.flags
    return [element.name for (element, flag), on in flags.items() if flag == "collidable" and element.kind == "body" and not on]


def plan_along(runtime: Runtime, poses: Sequence[FloatArray]) -> Plan:
    """Plan a motion of the tip through poses (7,), without stops and without collision checks."""
    runtime.refresh_planner()
    return runtime.planner.plan_curve(runtime.measured_start, list(poses))


def timed(runtime: Runtime, points: FloatArray, pace: Pace) -> Trajectory:
    """Return the fastest trajectory through configurations (m, n) [rad] within the limits, with zero velocity at both ends."""
    planner = runtime.planner
    return retime(
        points,
        runtime.model.limits.capped(pace.velocity, pace.acceleration),
        arc=ArcLimits(pace.velocity, pace.acceleration),
        torque=planner.torque,
        jerk_time=0.0 if pace.jerk >= USUAL_JERK else pace.acceleration / pace.jerk,
    )


def paced(runtime: Runtime, plan: Plan, pace: Pace) -> Trajectory:
    """Return the trajectory of a plan, retimed if the planner has other limits."""
    config = runtime.planner.config
    usual = Pace(config.max_velocity, config.max_acceleration, max(pace.jerk, USUAL_JERK))
    return plan.trajectory if pace == usual else timed(runtime, plan.path, pace)


def configurations(
    simulator: Simulator, pose: FloatArray, *, ignore_collisions: bool, starts: int, most: int
) -> list[FloatArray]:
    """Return up to `most` different configurations (n,) [rad] with the tip at a pose (7,), the nearest first."""
    runtime = simulator.runtime
    collision = None
    if not ignore_collisions:
        runtime.refresh_planner()
        collision = runtime.planner.collision
        collision.allow(may_be_touched(simulator))
    q, rng = runtime.robot.joint_positions, runtime.planning_rng
    return solve_ik(runtime.model, pose, q, rng, starts=starts, max_solutions=most, collision=collision)[:most]


def nearest_configuration(runtime: Runtime, pose: FloatArray) -> FloatArray:
    """Return the configuration (n,) [rad] for a tip pose (7,) that inverse kinematics finds from the current configuration."""
    return solve_ik(runtime.model, pose, runtime.robot.joint_positions, runtime.planning_rng, starts=1)[0]


def arm_collides(simulator: Simulator, name: str | None) -> bool:
    """Return whether the arm or a grasped body collides with the body `name`; None: with any collidable body, or itself.

    A grasped body collides with the gripper while they touch.
    """
    runtime = simulator.runtime
    if name in runtime.gripper.grasped:
        return name in runtime.robot.touching()
    runtime.refresh_planner()
    runtime.planner.collision.allow(uncollidable(simulator))
    if name is None:
        return runtime.planner.collision.in_collision(runtime.robot.joint_positions)
    return any(name in pair for pair in runtime.planner.collision.colliding_pairs(runtime.robot.joint_positions))


def _planner(runtime: Runtime, algorithm: str) -> MotionPlanner:
    """Return the planner of the runtime, or a new planner with the same settings and another algorithm."""
    config = runtime.planner.config
    wanted = replace(config, algorithm=ALGORITHMS.get(algorithm, config.algorithm))
    return runtime.planner if wanted == config else MotionPlanner(runtime.model, wanted)
