"""Joint-space paths around obstacles: search with coarse checks, shorten, round the corners, repair blocked edges.

`Connector` is RRT-Connect (Kuffner, LaValle 2000). It checks edges configuration by configuration, and keeps their free part.
Two trees grow towards each other, one from the start, one from all goals. It is optimised for collision checks of some
microseconds: trees are arrays, the nearest node is one matrix product, the smaller tree grows, samples are drawn in batches.
(With edges that shrink after a failure, the 95th percentile of the time was twenty times longer.)

The other planners are from OMPL. PRM and PRM* are excluded: their second thread waits for Python without end, and would make
results vary. AORRTC is excluded: it loops without end when its path cannot be improved.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

from rlbench_pin.errors import NoPath
from rlbench_pin.planning.continuous_collision import Rules
from rlbench_pin.planning.path import IsFree, JointPath, coarse_to_fine, edge_is_free, round_off
from rlbench_pin.planning.plan import ALGORITHMS, Algorithm, Stages
from rlbench_pin.robot.model import JointLimits
from rlbench_pin.spatial import FloatArray

__all__ = ["ALGORITHMS", "Algorithm", "Connector", "leave_out", "path_around", "sample_path", "shorten"]


_DRAWS = 64


class OutOfBudget(Exception):
    """The budget of collision checks is exhausted."""


class _Tree:
    """Configurations and the parent of each."""

    def __init__(self, roots: FloatArray) -> None:
        self.nodes = np.empty((256, roots.shape[1]))
        self.squares = np.empty(256)
        self.parents: list[int] = []
        for q in roots:
            self.add(q, -1)

    def add(self, q: FloatArray, parent: int) -> int:
        index = len(self.parents)
        if index == len(self.nodes):
            self.nodes = np.concatenate([self.nodes, np.empty_like(self.nodes)])
            self.squares = np.concatenate([self.squares, np.empty_like(self.squares)])
        self.nodes[index], self.squares[index] = q, q @ q
        self.parents.append(parent)
        return index

    def nearest(self, q: FloatArray) -> int:
        count = len(self.parents)
        return int(np.argmin(self.squares[:count] - 2.0 * (self.nodes[:count] @ q)))

    def branch(self, index: int) -> list[FloatArray]:
        """Return the configurations from a node back to its root."""
        result = []
        while index >= 0:
            result.append(self.nodes[index].copy())
            index = self.parents[index]
        return result


class Connector:
    """One search of RRT-Connect. Its budget is a number of collision checks, not a time."""

    def __init__(self, is_free: IsFree, *, checks: int, step: float, reach: float) -> None:
        """Prepare a search.

        Args:
            is_free: Collision check.
            checks: Budget of collision checks.
            step: Resolution of edge checks, in the norm of all joints [rad].
            reach: Longest edge [rad].
        """
        self.is_free, self.left, self.step, self.reach = is_free, checks, step, reach

    def search(
        self, q_start: FloatArray, goals: FloatArray, lower: FloatArray, upper: FloatArray, rng: np.random.Generator
    ) -> FloatArray | None:
        """Return a path (m, n) from `q_start` to one of `goals` (k, n), or None if the budget is exhausted."""
        trees = _Tree(q_start[None]), _Tree(goals)
        grown, drawn, samples = 0, 0, np.empty((0, len(lower)))
        try:
            while True:
                if drawn == len(samples):
                    samples, drawn = rng.uniform(lower, upper, (_DRAWS, len(lower))), 0
                target, drawn = samples[drawn], drawn + 1
                node = self._extend(trees[grown], target)
                if node is not None:
                    other = trees[1 - grown]
                    met = self._connect(other, trees[grown].nodes[node].copy())
                    if met is not None:
                        ends = (node, met) if grown == 0 else (met, node)
                        return np.array(trees[0].branch(ends[0])[::-1] + trees[1].branch(ends[1])[1:])
                if len(trees[1 - grown].parents) < len(trees[grown].parents):
                    grown = 1 - grown
        except OutOfBudget:
            return None

    def _extend(self, tree: _Tree, target: FloatArray) -> int | None:
        """Grow from the nearest node towards `target` by at most `reach`; return None if blocked."""
        near = tree.nearest(target)
        a = tree.nodes[near]
        way = target - a
        distance = math.sqrt(way @ way)
        if self.reach < distance:
            way *= self.reach / distance
            distance = self.reach
        return tree.add(a + way, near) if self._edge(a, way, distance) else None

    def _connect(self, tree: _Tree, target: FloatArray) -> int | None:
        """Grow from the nearest node to `target`, keep the free part, and return its last node."""
        near = tree.nearest(target)
        while True:
            a = tree.nodes[near]
            way = target - a
            distance = math.sqrt(way @ way)
            last = distance <= self.reach
            if not last:
                way *= self.reach / distance
                distance = self.reach
            if not self._edge(a, way, distance):
                return None
            near = tree.add(target if last else a + way, near)
            if last:
                return near

    def _edge(self, a: FloatArray, way: FloatArray, length: float) -> bool:
        """Return whether a line of a length from a free `a` along `way` is free, including its end."""
        for q in a + _edge_shares(int(length / self.step) + 2) * way:
            self.left -= 1
            if self.left < 0:
                raise OutOfBudget
            if not self.is_free(q):
                return False
        return True


@lru_cache(maxsize=1024)
def _edge_shares(count: int) -> FloatArray:
    """Return the parameters (0..1) of `count` even samples of an edge without the first (count - 1, 1), widely spaced first."""
    shares = np.array([i for i in coarse_to_fine(count) if i > 0])[:, None] * (1.0 / (count - 1))
    shares.flags.writeable = False
    return shares


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
ou.setLogLevel(ou.LOG_NONE)


class _Budget:
    """Counts state checks; after the last check all states are invalid, so that the planner stops."""

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
    """Return a path (m, n) of straight joint-space edges from `q_start` to one of `goals`; equal arguments give equal paths.

    Args:
        q_start: Free start configuration (n,), [rad].
        goals: Free goal configurations.
        is_free: Collision check.
        limits: Bounds of the space.
        seed: Seed of OMPL's generators, positive.
        algorithm: Name of the planner.
        checks: Budget of state checks; optimising planners use all of it.
        step: Resolution of edge checks, in the norm of all joints [rad].
        range_: Longest edge of tree planners [rad]; None uses the default of the planner.

    Raises:
        NoPath: The budget is exhausted without a path to a goal.
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


class _Counted:
    """A collision check that reports a collision once its budget is spent."""

    def __init__(self, is_free: IsFree, checks: int) -> None:
        self._is_free, self.left = is_free, checks

    def __call__(self, q: FloatArray) -> bool:
        self.left -= 1
        return self.left >= 0 and self._is_free(q)


def shorten(path: FloatArray, is_free: IsFree, rng: np.random.Generator, *, step: float = 0.05, checks: int = 600) -> FloatArray:
    """Shorten a free polyline (m, n) with at most `checks` collision checks; its ends do not change.

    Args:
        path: Vertices with free edges, [rad].
        is_free: Collision check.
        rng: Generator of the shortcuts.
        step: Resolution of edge checks [rad].
        checks: Budget.
    """
    counted = _Counted(is_free, checks)
    path = leave_out(path, counted, step)
    misses, along = 0, _lengths_along(path)
    while counted.left > 0 and misses < 12 and len(path) > 2:
        shorter = _cut(path, along, counted, rng, step)
        misses = misses + 1 if shorter is None else 0
        if shorter is not None:
            path, along = shorter, _lengths_along(shorter)
    return leave_out(path, counted, step)


def leave_out(path: FloatArray, is_free: IsFree, step: float) -> FloatArray:
    """Connect each vertex, from the start, to the farthest later vertex with a free edge."""
    kept = [0]
    while kept[-1] < len(path) - 1:
        here = kept[-1]
        there = len(path) - 1
        while there > here + 1 and not edge_is_free(path[here], path[there], is_free, step):
            there = here + 1 + (there - here - 1) // 2 if there - here > 2 else here + 1
        kept.append(there)
    return path[kept]


def _lengths_along(path: FloatArray) -> tuple[list[float], list[float]]:
    """Return the length of each edge of a polyline (m, n), and the path length to each vertex, [rad]."""
    way = np.diff(path, axis=0)
    lengths = np.sqrt((way * way).sum(axis=1))
    return lengths.tolist(), [0.0, *np.cumsum(lengths).tolist()]


def _cut(
    path: FloatArray, along: tuple[list[float], list[float]], is_free: IsFree, rng: np.random.Generator, step: float
) -> FloatArray | None:
    """Try to replace the part between two random points of the polyline by one edge; return None if that is not shorter."""
    lengths, total = along
    low, high = sorted((total[-1] * rng.random(), total[-1] * rng.random()))
    i, j = (bisect_right(total, where, hi=len(lengths)) - 1 for where in (low, high))
    if i == j:
        return None
    a = path[i] + (low - total[i]) / lengths[i] * (path[i + 1] - path[i])
    b = path[j] + (high - total[j]) / lengths[j] * (path[j + 1] - path[j])
    way = b - a
    if math.sqrt(way @ way) > 0.98 * (high - low) or not edge_is_free(a, b, is_free, step):
        return None
    return np.concatenate([path[: i + 1], [a, b], path[j + 1 :]])


_REPAIRS = 3


def path_around(
    q_start: FloatArray,
    goals: Sequence[FloatArray],
    rules: Rules,
    limits: JointLimits,
    rng: np.random.Generator,
    stages: Stages,
) -> JointPath:
    """Return a smooth path that keeps the rules, from `q_start` to one of `goals`.

    Raises:
        NoPath: The budget of checks is exhausted.
    """
    config = rules.config
    left = config.checks
    for attempt in range(config.attempts):
        step = max(config.check_step, config.edge_step / 2**attempt)
        with stages.stage("search"):
            began = rules.collision.checks
            path = sample_path(
                q_start, goals, rules.is_free, limits,
                seed=int(rng.integers(1, 2**31 - 1)), algorithm=config.algorithm, checks=max(1, left), step=2.0 * step,
            )  # fmt: skip
            left -= rules.collision.checks - began
        with stages.stage("shorten"):
            path = shorten(path, rules.is_free, rng, step=step, checks=config.simplify_checks)
        with stages.stage("smooth"):
            smooth = round_off(path, rules.first_violation, repair=lambda corners: repair(corners, rules, limits, rng))
        if smooth is not None:
            return smooth
    raise NoPath(f"{config.attempts} paths were found, but none could be smoothed", config.checks - left)


def repair(path: FloatArray, rules: Rules, limits: JointLimits, rng: np.random.Generator) -> FloatArray | None:
    """Replace edges that fail the fine check by finely checked detours; return None if an edge has no detour."""
    for _ in range(_REPAIRS):
        blocked = rules.blocked_edges(path)
        if not blocked:
            return path
        for i in reversed(blocked):
            detour = _detour(path[i], path[i + 1], rules, limits, rng)
            if detour is None:
                return None
            path = np.concatenate([path[:i], detour, path[i + 2 :]])
    return None


def _detour(a: FloatArray, b: FloatArray, rules: Rules, limits: JointLimits, rng: np.random.Generator) -> FloatArray | None:
    config = rules.config
    try:
        way = sample_path(
            a, [b], rules.is_free, limits, seed=int(rng.integers(1, 2**31 - 1)), algorithm=config.algorithm,
            checks=config.checks // 4, step=config.check_step, range_=0.5,
        )  # fmt: skip
    except NoPath:
        return None
    return shorten(way, rules.is_free, rng, step=config.check_step, checks=config.simplify_checks)
