"""Smooth paths around obstacles: search with coarse checks, shorten, round the corners, repair edges that prove to be blocked."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rlbench_pin.errors import NoPath
from rlbench_pin.planning.path import JointPath, round_off
from rlbench_pin.planning.plan import PlannerConfig
from rlbench_pin.planning.rules import Rules
from rlbench_pin.planning.search.sampling import sample_path
from rlbench_pin.planning.search.simplify import shorten
from rlbench_pin.planning.stages import Stages
from rlbench_pin.robot.model import JointLimits
from rlbench_pin.spatial import FloatArray

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
        NoPath: The budget of checks was spent.
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
    """Replace the edges that only a coarse check let pass by ways around, checked finely; None when one has no such way."""
    config = rules.config
    for _ in range(_REPAIRS):
        blocked = rules.blocked_edges(path, config.check_step)
        if not blocked:
            return path
        for i in reversed(blocked):
            detour = _detour(path[i], path[i + 1], rules.config, rules, limits, rng)
            if detour is None:
                return None
            path = np.concatenate([path[:i], detour, path[i + 2 :]])
    return None


def _detour(
    a: FloatArray, b: FloatArray, config: PlannerConfig, rules: Rules, limits: JointLimits, rng: np.random.Generator
) -> FloatArray | None:
    try:
        way = sample_path(
            a, [b], rules.is_free, limits,
            seed=int(rng.integers(1, 2**31 - 1)), checks=config.checks // 4, step=config.check_step, range_=0.5,
        )  # fmt: skip
    except NoPath:
        return None
    return shorten(way, rules.is_free, rng, step=config.check_step, checks=config.simplify_checks)
