"""Layouts of several things at once."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.errors import BoundaryError
from rlbench_pin.spatial import pose_at
from rlbench_pin.tasks import SpawnBoundary, clearance
from rlbench_pin.tasks.spawn_boundary import MAX_LAYOUTS
from tests.tasks.stand_ins import FakeBody, FakeFrame

REGION = FakeFrame("patch", size=(0.6, 0.6, 0.0))


def cubes(count: int) -> list[FakeBody]:
    """Small cubes."""
    return [FakeBody(f"cube{i}", box=(0.05, 0.05, 0.05)) for i in range(count)]


def test_scattering_is_sampling_one_after_another() -> None:
    """Same draws, same places; what was placed before is forgotten."""
    ones, others, boundary = cubes(3), cubes(3), SpawnBoundary([REGION])
    rng = np.random.default_rng(3)
    for body in ones:
        boundary.sample(body, rng, min_distance=0.1)
    boundary.scatter(others, np.random.default_rng(3), min_distance=0.1)
    assert len(boundary.state()) == 3
    for one, other in zip(ones, others, strict=True):
        np.testing.assert_array_equal(one.pose, other.pose)


def test_a_layout_is_drawn_anew_until_it_is_accepted() -> None:
    """Here until the first cube stands apart."""
    bodies, boundary = cubes(4), SpawnBoundary([REGION])
    for seed in range(20):
        boundary.scatter(bodies, np.random.default_rng(seed), accept=lambda: clearance(bodies[0], bodies) > 0.25)
        assert clearance(bodies[0], bodies) > 0.25
        assert len(boundary.state()) == 4


def test_a_layout_that_is_never_accepted_is_an_error() -> None:
    """The message names the things and the remedy."""
    asked: list[bool] = []
    with pytest.raises(BoundaryError, match=f"None of {MAX_LAYOUTS} layouts of cube0, cube1 was accepted. Enlarge"):
        SpawnBoundary([REGION]).scatter(cubes(2), np.random.default_rng(0), accept=lambda: bool(asked.append(True)))
    assert len(asked) == MAX_LAYOUTS


def test_clearance_is_horizontal_and_leaves_the_thing_itself_out() -> None:
    """Alone it is endless."""
    low, high = FakeBody("low"), FakeBody("high", pose=pose_at((0.3, 0.4, 2.0)))
    assert clearance(low, [low, high]) == pytest.approx(0.5)
    assert clearance(low, [low]) == np.inf


def test_a_place_may_be_farther_from_some_things_than_from_others() -> None:
    """The larger of two distances counts; things that are not named keep the usual one."""
    near, far, boundary = FakeBody("near"), FakeBody("far"), SpawnBoundary([REGION])
    bodies = cubes(6)
    for seed in range(5):
        boundary.clear()
        rng = np.random.default_rng(seed)
        for body in (near, far):
            boundary.sample(body, rng, min_distance=0.05)
        for body in bodies:
            boundary.sample(body, rng, min_distance=0.05, apart={"far": 0.2, "near": 0.01})
        assert clearance(far, bodies) >= 0.2
        assert clearance(near, bodies) >= 0.05
