"""The way of the tip to each waypoint, as a demonstration in this layout would plan it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

import numpy as np

from rlbench_pin.builder.contracts import PlannedPath
from rlbench_pin.builder.stage.inside.reachability import Reacher, Visit
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.errors import NotStraight, PlanningError
from rlbench_pin.planning.kinematics import solve_ik
from rlbench_pin.planning.plan import Plan
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray

MOST_POINTS = 80
"""Points of a path that are shown."""
OTHER_STARTS = 24
"""Configurations that are tried where a line cannot be followed from the first one."""


def planned_paths(runtime: Runtime, on_path: Callable[[PlannedPath], None]) -> tuple[PlannedPath, ...]:
    """Plan the motion to each waypoint from where the one before it ends; a leg without a way is left out and gone over.

    Args:
        runtime: The running task, as it is laid out.
        on_path: Called with every path.
    """
    reacher, q = Reacher(runtime), np.array(runtime.description.home)
    paths: list[PlannedPath] = []
    for visit in reacher.visits():
        reacher.show(visit.fingers)
        path, q = _path(runtime, visit, q)
        paths.append(path)
        on_path(path)
    return tuple(paths)


def _path(runtime: Runtime, visit: Visit, q: FloatArray) -> tuple[PlannedPath, FloatArray]:
    """Return the path of one leg, and the configuration (n,) from which the next one begins."""
    name = visit.waypoint.frame.name
    try:
        plan = _plan_somehow(runtime, visit, q)
    except PlanningError as error:
        reached = visit.verdict.configuration
        return PlannedPath(name, np.zeros((0, 3)), "", str(error)), q if reached is None else reached
    return PlannedPath(name, _tip_points(runtime.model, plan.path), plan.report.method), np.array(plan.path[-1])


def _plan_somehow(runtime: Runtime, visit: Visit, q: FloatArray) -> Plan:
    """Plan from a configuration (n,); a line that cannot be followed from there, from others at the same pose of the tip.

    A demonstration ends the leg before where this one can be followed.
    """
    try:
        return _plan(runtime, visit, q)
    except NotStraight as error:
        limits, rng, tip = runtime.model.limits, runtime.planning_rng, runtime.model.tip_pose(q)
        for _ in range(OTHER_STARTS):
            with suppress(PlanningError):
                other = solve_ik(runtime.model, tip, rng.uniform(limits.lower, limits.upper), rng, starts=1)[0]
                return _plan(runtime, visit, other)
        raise error


def _plan(runtime: Runtime, visit: Visit, q: FloatArray) -> Plan:
    planner, waypoint, rng = runtime.planner, visit.waypoint, runtime.planning_rng
    if waypoint.path == "curve":
        return planner.plan_curve(q, visit.poses, ignore_collisions=True, rng=rng)
    return planner.plan_to_pose(
        q,
        visit.poses[0],
        straight=True if waypoint.path == "straight" else None,
        ignore_collisions=waypoint.ignore_collisions,
        allowed=visit.allowed,
        rng=rng,
    )


def _tip_points(model: RobotModel, path: FloatArray) -> FloatArray:
    """Return positions (m, 3) of the tip along configurations (k, n), about evenly many everywhere."""
    chosen = np.unique(np.linspace(0, len(path) - 1, min(len(path), MOST_POINTS)).round().astype(int))
    return np.array([model.tip_pose(path[i])[:3] for i in chosen])
