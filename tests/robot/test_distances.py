"""Distances, their gradients, and the bounds that save measuring."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.robot.collision import CollisionModel
from rlbench_pin.robot.distances import DistanceModel
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.snapshot import WorldSnapshot
from tests.worlds_for_tests import Boxes


@pytest.fixture
def world(boxes: Boxes) -> WorldSnapshot:
    """A table with a screen and cubes, one of them in the hand."""
    cubes = boxes.cubes(6)
    return boxes.snapshot(boxes.screen(), *cubes, attached=(cubes[0].name,))


@pytest.fixture
def distances(model: RobotModel, world: WorldSnapshot) -> DistanceModel:
    """Distances in that world."""
    result = DistanceModel(model)
    result.update(world)
    return result


def draw(model: RobotModel, rng: np.random.Generator) -> np.ndarray:
    """Return a random configuration."""
    return rng.uniform(model.limits.lower, model.limits.upper)


def test_distances_agree_with_the_collision_model(model: RobotModel, world: WorldSnapshot, distances: DistanceModel) -> None:
    """The nearest distance is the one the collision model finds, between the same things."""
    other, rng = CollisionModel(model), np.random.default_rng(0)
    other.update(world)
    for _ in range(20):
        q = draw(model, rng)
        mine, theirs = distances.nearest(q, 3), other.distances(q)[:3]
        np.testing.assert_allclose([d.distance for d in mine], [d.distance for d in theirs], atol=1e-6)
        np.testing.assert_allclose(mine[0].point_a + mine[0].distance * mine[0].normal, mine[0].point_b, atol=1e-6)


def test_gradients_equal_finite_differences(model: RobotModel, distances: DistanceModel) -> None:
    """The gradient of every distance by the joint angles is right to 1e-6 where the shapes are apart."""
    rng, everything, step = np.random.default_rng(1), np.arange(len(distances.bounds)), 1e-5
    for _ in range(10):
        q = draw(model, rng)
        distances.place(q)
        apart = distances.measure(everything) > 1e-3
        gradients = distances.gradients(everything)
        for j in range(model.size):
            change = np.zeros(model.size)
            change[j] = step
            distances.visit(q + change)
            above = distances.probe(everything)
            distances.visit(q - change)
            difference = (above - distances.probe(everything)) / (2.0 * step)
            assert np.quantile(np.abs(difference - gradients[:, j])[apart], 0.99) < 1e-6


def test_bounds_are_below_distances(model: RobotModel, distances: DistanceModel) -> None:
    """What `place` promises without measuring is never more than the truth, where it promises anything."""
    rng, everything = np.random.default_rng(2), np.arange(len(distances.bounds))
    for _ in range(50):
        distances.place(draw(model, rng))
        bounds = distances.bounds.copy()
        true = distances.measure(everything)
        assert np.all((bounds <= 0.0) | (bounds <= true + 1e-9))


def test_nothing_moves_farther_than_the_bound(model: RobotModel, distances: DistanceModel) -> None:
    """Over small and large motions, no distance changes by more than the displacement bound."""
    rng, everything = np.random.default_rng(3), np.arange(len(distances.bounds))
    for size in (0.01, 0.1, 1.0):
        for _ in range(20):
            q, turn = draw(model, rng), size * rng.normal(size=model.size)
            distances.place(q)
            before = distances.measure(everything).copy()
            bound = distances.motion.displacement(np.abs(turn))
            distances.visit(q + turn)
            assert np.all(np.abs(distances.probe(everything) - before) <= bound + 1e-6)


def test_a_distance_does_not_depend_on_the_ones_before(model: RobotModel, distances: DistanceModel) -> None:
    """Measured again after other configurations, every bit is the same."""
    rng, everything = np.random.default_rng(4), np.arange(len(distances.bounds))
    q = draw(model, rng)
    distances.visit(q)
    first = distances.probe(everything)
    for _ in range(5):
        distances.visit(draw(model, rng))
        distances.probe(everything)
    distances.visit(q)
    np.testing.assert_array_equal(distances.probe(everything), first)


def test_allowed_bodies_do_not_count(model: RobotModel, world: WorldSnapshot, distances: DistanceModel) -> None:
    """Pairs with a body named as allowed are left out of what is nearest."""
    assert distances.counts.all()
    distances.update(world, allowed=("cube1",))
    assert not distances.counts.all()
    assert all("cube1" not in (d.a, d.b) for d in distances.nearest(model.home, 300))
