"""Smooth geometric paths."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import BSpline

from rlbench_pin.planning.path import JointPath, along, coarse_to_fine, edge_is_free, round_off, through

CORNER = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])


def distance_to_polyline(points: np.ndarray, vertices: np.ndarray) -> np.ndarray:
    """Distance of every point (m, 2) to the nearest edge."""
    distances = []
    for a, b in zip(vertices[:-1], vertices[1:], strict=True):
        t = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
        distances.append(np.linalg.norm(points - a - t[:, None] * (b - a), axis=1))
    return np.min(distances, axis=0)


def test_a_rounded_polyline_keeps_its_ends() -> None:
    """The curve starts and ends where the polyline does."""
    path = along(CORNER, 0.2)
    np.testing.assert_allclose(path.start, CORNER[0])
    np.testing.assert_allclose(path.end, CORNER[-1])


@pytest.mark.parametrize("radius", [0.3, 0.1, 0.01])
def test_rounding_shrinks_with_its_radius(radius: float) -> None:
    """The curve leaves the polyline by less than the radius, and by next to nothing when that is small."""
    _, points = along(CORNER, radius).spread(0.002)
    assert distance_to_polyline(points, CORNER).max() < 0.5 * radius


def test_one_edge_is_a_straight_line() -> None:
    """Two vertices give the joint-space line."""
    _, points = along(CORNER[:2], 1.0).spread(0.01)
    np.testing.assert_allclose(points[:, 1], 0.0, atol=1e-12)


def test_curves_are_smooth() -> None:
    """Position, tangent and bend do not jump."""
    path = along(np.vstack([CORNER, [[0.0, 2.0]]]), 0.2)
    s = np.linspace(0.0, 1.0, 4001)
    for order in (0, 1, 2):
        values = path(s, order)
        jumps = np.abs(np.diff(values, axis=0)).max()
        assert jumps < 0.02 * max(1.0, np.abs(values).max())


def test_interpolation_passes_its_points() -> None:
    """Every point is met, repeated ones do no harm."""
    points = np.array([[0.0, 0.0], [0.1, 0.3], [0.1, 0.3], [0.5, 0.2], [0.6, 0.1], [0.9, 0.9]])
    _, found = through(points).spread(1e-4)
    assert all(np.linalg.norm(found - p, axis=1).min() < 1e-3 for p in points)


def test_spread_is_even() -> None:
    """Neighbours are at most one step apart, and both ends are among them."""
    s, points = along(CORNER, 0.3).spread(0.05)
    assert s[0] == 0.0
    assert s[-1] == 1.0
    assert np.abs(np.diff(points, axis=0)).max() < 0.06


def test_a_path_without_length_stays() -> None:
    """Equal ends are no special case."""
    path = along(np.zeros((2, 3)), 1.0)
    assert path.length() == 0.0
    np.testing.assert_array_equal(path.end, np.zeros(3))


@pytest.mark.parametrize("count", [1, 2, 3, 8, 17, 100])
def test_coarse_to_fine_visits_all_once(count: int) -> None:
    """It is a permutation."""
    assert sorted(coarse_to_fine(count)) == list(range(count))


def test_edges_are_checked_in_between() -> None:
    """A small obstacle in the middle of an edge is found when it is larger than the step."""

    def is_free(q: np.ndarray) -> bool:
        return abs(q[0] - 0.63) > 0.02

    assert not edge_is_free(CORNER[0], CORNER[1], is_free, 0.03)
    assert edge_is_free(CORNER[0], np.array([0.5, 0.0]), is_free, 0.03)


def test_corners_are_rounded_as_far_as_is_free() -> None:
    """Near an obstacle in the corner the rounding tightens; a blocked corner gives nothing."""

    def is_free(q: np.ndarray) -> bool:
        return bool(np.linalg.norm(q - [0.9, 0.1]) > 0.1)

    wide, tight = along(CORNER, 0.4), round_off(CORNER, lambda path: path.first_collision(is_free, 0.005))
    assert wide.first_collision(is_free, 0.005) is not None
    assert tight is not None
    assert tight.first_collision(is_free, 0.005) is None
    shut = round_off(CORNER, lambda path: path.first_collision(lambda q: bool(np.linalg.norm(q - [1.0, 0.0]) > 0.1), 0.005))
    assert shut is None


@pytest.mark.parametrize("corners", [2, 3, 7])
def test_derivatives_are_those_of_scipy_to_the_last_bit(corners: int) -> None:
    """They are made without its checks, of rounded polylines and of curves through points alike."""
    points, s = np.random.default_rng(corners).normal(size=(corners, 7)), np.linspace(0.0, 1.0, 50)
    for path in (along(points, 0.3), through(points)):
        spline = path.spline
        for order in (1, 2):
            np.testing.assert_array_equal(path(s, order), spline.derivative(order)(s))


def test_a_path_with_a_corner_is_none() -> None:
    """A spline whose inner knots are repeated has no second derivative there."""
    knots = np.array([0.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.5, 1.0, 1.0, 1.0, 1.0])
    with pytest.raises(ValueError, match="repeated"):
        JointPath(BSpline(knots, np.zeros((7, 2)), 3))


def test_pieces_are_bezier_curves_of_the_path() -> None:
    """Control points of any part of a piece give the path back."""
    path = along(CORNER, 0.4)
    low, high = path.knots[:-1], path.knots[1:]
    for a, b in ((low, high), (low, 0.5 * (low + high)), (0.3 * low + 0.7 * high, high)):
        control, t = path.bezier(a, b), 0.37
        weights = np.array([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
        np.testing.assert_allclose(np.einsum("k,mkn->mn", weights, control), path(a + t * (b - a)), atol=1e-12)


def test_points_are_near_each_other_and_may_be_changed() -> None:
    """What a plan shows of its path is a copy."""
    path = along(CORNER, 0.4)
    points = path.points()
    assert np.abs(np.diff(points, axis=0)).max() < 0.055
    points[:] = 9.0
    np.testing.assert_allclose(path.points()[[0, -1]], CORNER[[0, -1]])
