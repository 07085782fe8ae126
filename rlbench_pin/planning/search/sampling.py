"""Joint-space paths around obstacles: by an RRT-Connect of our own, and by the sampling-based planners of OMPL.

Left out are PRM and PRM*, whose second thread never ends its wait for Python and would make results vary, and AORRTC, which was
seen to loop without end once its path could not be improved.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal, get_args

import numpy as np
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

from rlbench_pin.errors import NoPath
from rlbench_pin.planning.path import IsFree
from rlbench_pin.planning.search.connect import Connector
from rlbench_pin.robot.model import JointLimits
from rlbench_pin.spatial import FloatArray

Algorithm = Literal[
    "rrt_connect", "ompl_rrt_connect", "rrt", "rrt_star", "informed_rrt_star", "sorrt_star", "bit_star",
    "kpiece", "bkpiece", "lbkpiece",
]  # fmt: skip
_PLANNERS: dict[str, Callable[[ob.SpaceInformation], ob.Planner]] = {
    "ompl_rrt_connect": og.RRTConnect,
    "rrt": og.RRT,
    "rrt_star": og.RRTstar,
    "informed_rrt_star": og.InformedRRTstar,
    "sorrt_star": og.SORRTstar,
    "bit_star": og.BITstar,
    "kpiece": og.KPIECE1,
    "bkpiece": og.BKPIECE1,
    "lbkpiece": og.LBKPIECE1,
}
_REACH, _OMPL_RANGE = 1.5, 0.6
ALGORITHMS: tuple[str, ...] = get_args(Algorithm)
ou.setLogLevel(ou.LOG_NONE)


class _Budget:
    """Counts state checks; after the last one every state is refused, so that the planner stops."""

    def __init__(self, is_free: IsFree, size: int, checks: int) -> None:
        self._is_free, self._size, self.left = is_free, size, checks
        self._q = np.empty(size)

    def is_valid(self, state: ob.State) -> bool:
        self.left -= 1
        if self.left < 0:
            return False
        q = self._q
        for i in range(self._size):
            q[i] = state[i]
        return bool(self._is_free(q))

    def is_spent(self) -> bool:
        return self.left <= 0


def sample_path(
    q_start: FloatArray,
    goals: Sequence[FloatArray],
    is_free: IsFree,
    limits: JointLimits,
    *,
    seed: int,
    algorithm: Algorithm = "rrt_connect",
    checks: int = 20_000,
    step: float = 0.05,
    range_: float | None = None,
) -> FloatArray:
    """Find a path (m, n) of straight joint-space edges from `q_start` to one of `goals`; the same arguments give the same path.

    Args:
        q_start: Free start configuration (n,), [rad].
        goals: Free goal configurations.
        is_free: Collision check.
        limits: Bounds of the space.
        seed: Seed of OMPL's generators, positive.
        algorithm: Which planner.
        checks: Budget of state checks; planners that optimise use all of it.
        step: Resolution of edge checks, in the norm of all joints [rad].
        range_: Longest edge of tree planners [rad]; None for what suits the planner.

    Raises:
        NoPath: The budget was spent without reaching a goal.
    """
    search: Connector | _Budget
    if algorithm == "rrt_connect":
        search = Connector(is_free, checks=checks, step=step, reach=range_ or _REACH)
        path = search.search(q_start, np.array(goals), limits.lower, limits.upper, np.random.default_rng(seed))
    else:
        search = _Budget(is_free, len(q_start), checks)
        ou.RNG.setSeed(seed)
        path = _solve(q_start, goals, search, limits, algorithm, step, range_ or _OMPL_RANGE)
    if path is None:
        raise NoPath(f"{algorithm} found no connection to {len(goals)} goal configurations", checks - max(0, search.left))
    return path


def _solve(
    q_start: FloatArray,
    goals: Sequence[FloatArray],
    budget: _Budget,
    limits: JointLimits,
    algorithm: str,
    step: float,
    range_: float,
) -> FloatArray | None:
    space = _space(limits, step)
    information = ob.SpaceInformation(space)
    information.setStateValidityChecker(budget.is_valid)
    information.setup()
    problem = ob.ProblemDefinition(information)
    problem.addStartState(_state(space, q_start))
    goal = ob.GoalStates(information)
    for q in goals:
        goal.addState(_state(space, q))
    problem.setGoal(goal)
    problem.setOptimizationObjective(ob.PathLengthOptimizationObjective(information))
    planner = _PLANNERS[algorithm](information)
    if hasattr(planner, "setRange"):
        planner.setRange(range_)
    planner.setProblemDefinition(problem)
    planner.setup()
    planner.solve(ob.PlannerTerminationCondition(budget.is_spent))
    if not problem.hasExactSolution():
        return None
    states = problem.getSolutionPath().getStates()
    return np.array([[state[i] for i in range(len(q_start))] for state in states])


def _space(limits: JointLimits, step: float) -> ob.RealVectorStateSpace:
    size = len(limits.lower)
    space = ob.RealVectorStateSpace(size)
    box = ob.RealVectorBounds(size)
    for i in range(size):
        box.setLow(i, float(limits.lower[i]))
        box.setHigh(i, float(limits.upper[i]))
    space.setBounds(box)
    space.setLongestValidSegmentFraction(step / space.getMaximumExtent())
    return space


def _state(space: ob.RealVectorStateSpace, q: FloatArray) -> ob.State:
    state = space.allocState()
    for i, value in enumerate(q):
        state[i] = float(value)
    return state
