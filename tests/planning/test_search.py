"""Searching paths around obstacles, and shortening them."""

from __future__ import annotations

import subprocess
import sys
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from rlbench_pin.errors import NoPath
from rlbench_pin.planning.continuous_collision import Rules
from rlbench_pin.planning.path import edge_is_free
from rlbench_pin.planning.plan import PlannerConfig
from rlbench_pin.planning.search import ALGORITHMS, leave_out, repair, sample_path, shorten
from rlbench_pin.robot.model import JointLimits

ONE = np.ones(2)
SQUARE = JointLimits(-ONE, ONE, ONE, ONE, ONE)
START, GOAL = np.array([-0.9, 0.0]), np.array([0.9, 0.0])


def wall_with_gap(q: np.ndarray) -> bool:
    """A wall at x = 0 that is open for y > 0.5."""
    return bool(abs(q[0]) > 0.1 or q[1] > 0.5)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_every_algorithm_finds_the_gap(algorithm: str) -> None:
    """The path joins start and goal by free edges."""
    path = sample_path(START, [GOAL], wall_with_gap, SQUARE, seed=1, algorithm=algorithm, checks=8000, step=0.02)  # type: ignore[arg-type]
    np.testing.assert_array_equal(path[[0, -1]], [START, GOAL])
    assert all(edge_is_free(a, b, wall_with_gap, 0.02) for a, b in pairwise(path))


def test_one_of_several_goals_is_reached() -> None:
    """A goal that is shut in does no harm."""

    def is_free(q: np.ndarray) -> bool:
        return bool(q[0] < 0.5 or q[0] > 0.8)

    path = sample_path(START, [GOAL, np.array([0.3, 0.3])], is_free, SQUARE, seed=1)
    np.testing.assert_array_equal(path[-1], [0.3, 0.3])


def test_the_budget_is_kept() -> None:
    """Without a way the search ends after the checks it was given, not after a time."""
    calls = 0

    def is_free(q: np.ndarray) -> bool:
        nonlocal calls
        calls += 1
        return bool(abs(q[0]) > 0.1)

    with pytest.raises(NoPath) as caught:
        sample_path(START, [GOAL], is_free, SQUARE, seed=1, checks=700)
    assert calls <= 700
    assert caught.value.checks == 700


def test_the_seed_alone_decides() -> None:
    """Planning something else in between changes nothing; another seed does."""
    first = sample_path(START, [GOAL], wall_with_gap, SQUARE, seed=7)
    sample_path(GOAL, [START], wall_with_gap, SQUARE, seed=3, algorithm="kpiece")
    np.testing.assert_array_equal(sample_path(START, [GOAL], wall_with_gap, SQUARE, seed=7), first)
    other = sample_path(START, [GOAL], wall_with_gap, SQUARE, seed=8)
    assert other.shape != first.shape or not np.array_equal(other, first)


@pytest.mark.simulation
def test_another_process_agrees_and_is_silent() -> None:
    """The same bytes come out of a fresh process, which prints nothing else, not even at its end."""
    code = (
        "import numpy as np, sys; sys.path.insert(0, '.');"
        "from tests.planning.test_search import *;"
        "sys.stdout.write(sample_path(START, [GOAL], wall_with_gap, SQUARE, seed=7).tobytes().hex())"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stderr == ""
    assert run.stdout == sample_path(START, [GOAL], wall_with_gap, SQUARE, seed=7).tobytes().hex()


ZIGZAG = np.array([[0.0, 0.0], [0.2, 0.6], [0.4, -0.3], [0.6, 0.7], [0.8, 0.1], [1.0, 0.0]])


def length(path: np.ndarray) -> float:
    """Length of a polyline."""
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def outside_disc(q: np.ndarray) -> bool:
    """A disc on the straight way."""
    return bool(np.linalg.norm(q - [0.5, 0.0]) > 0.2)


def test_without_obstacles_only_the_ends_remain(rng: np.random.Generator) -> None:
    """The shortest path is the edge from start to goal."""
    np.testing.assert_array_equal(shorten(ZIGZAG, lambda q: True, rng), ZIGZAG[[0, -1]])
    np.testing.assert_array_equal(leave_out(ZIGZAG, lambda q: True, 0.05), ZIGZAG[[0, -1]])


def test_shortcuts_are_free_and_shorter(rng: np.random.Generator) -> None:
    """Around an obstacle the path comes near its shortest length and keeps clear."""
    detour = np.array([[0.0, 0.0], [0.0, 0.9], [1.0, 0.9], [1.0, 0.0]])
    path = shorten(detour, outside_disc, rng, step=0.01, checks=5000)
    assert all(edge_is_free(a, b, outside_disc, 0.01) for a, b in pairwise(path))
    assert length(path) < 0.6 * length(detour)
    np.testing.assert_array_equal(path[[0, -1]], detour[[0, -1]])


def test_the_budget_of_shortcuts_is_kept(rng: np.random.Generator) -> None:
    """No more checks are made than allowed, and the result is still free."""
    calls = 0

    def counted(q: np.ndarray) -> bool:
        nonlocal calls
        calls += 1
        return outside_disc(q)

    path = shorten(np.array([[0.0, 0.0], [0.0, 0.9], [1.0, 0.9], [1.0, 0.0]]), counted, rng, step=0.01, checks=150)
    assert calls <= 150
    assert all(edge_is_free(a, b, outside_disc, 0.01) for a, b in pairwise(path))


@pytest.mark.parametrize("algorithm", ["rrt_connect", "rrt"])
def test_a_blocked_edge_is_repaired_with_the_algorithm_of_the_config(algorithm: str) -> None:
    """The edge through the wall becomes the shortened path that this algorithm finds."""
    config = PlannerConfig(algorithm=algorithm)  # type: ignore[arg-type]
    collision = SimpleNamespace(collides=lambda q: not wall_with_gap(q))
    rules = Rules(collision, config, SimpleNamespace())  # type: ignore[arg-type]
    repaired = repair(np.array([START, GOAL]), rules, SQUARE, np.random.default_rng(0))
    rng = np.random.default_rng(0)
    found = sample_path(
        START, [GOAL], wall_with_gap, SQUARE, seed=int(rng.integers(1, 2**31 - 1)),
        algorithm=algorithm, checks=config.checks // 4, step=config.check_step, range_=0.5,  # type: ignore[arg-type]
    )  # fmt: skip
    np.testing.assert_array_equal(repaired, shorten(found, wall_with_gap, rng, step=config.check_step, checks=1000))
