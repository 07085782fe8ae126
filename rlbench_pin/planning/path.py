"""Paths in joint space: straight edges, smoothing, and Cartesian lines and curves that the tip follows."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np
import pinocchio as pin
from scipy.interpolate import BSpline, CubicSpline, make_interp_spline
from scipy.spatial.transform import Rotation, RotationSpline

from rlbench_pin.errors import InvalidRequest, NotStraight
from rlbench_pin.planning.kinematics import as_configuration, as_goal_pose, as_goal_poses, descend
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray, PoseLike, pose_to_se3
from rlbench_pin.values import as_record

IsFree = Callable[[FloatArray], bool]
"""Function that returns whether a configuration (n,) is free of collisions."""

_SAMPLES_PER_SEGMENT = 8
"""Number of samples per cubic piece to measure distances along the path."""


class JointPath:
    """A cubic spline q(s) on 0 <= s <= 1, twice continuously differentiable."""

    def __init__(self, spline: BSpline) -> None:
        """Use a cubic spline on 0..1 with values of shape (n,), [rad]."""
        slope = _derivative(as_record(spline, BSpline, "spline"))
        self._orders = (spline, slope, _derivative(slope))

    def __call__(self, s: FloatArray | float, order: int = 0) -> FloatArray:
        """Return q, dq/ds or d2q/ds2 at parameters `s`, shape (m, n)."""
        return self._orders[order](s)

    @property
    def spline(self) -> BSpline:
        """The spline itself."""
        return self._orders[0]

    @property
    def start(self) -> FloatArray:
        """First configuration (n,)."""
        return self(0.0)

    @property
    def end(self) -> FloatArray:
        """Last configuration (n,)."""
        return self(1.0)

    @cached_property
    def knots(self) -> FloatArray:
        """Start parameters of the cubic pieces, and 1, shape (m,)."""
        return np.unique(self._orders[0].t)

    @cached_property
    def _measured(self) -> tuple[FloatArray, FloatArray]:
        """Parameters, eight per piece, and the joint distances up to them [rad], both (m,)."""
        knots = self.knots
        s = np.append(
            (knots[:-1, None] + np.diff(knots)[:, None] * (np.arange(_SAMPLES_PER_SEGMENT) / _SAMPLES_PER_SEGMENT)).ravel(), 1.0
        )
        return s, np.concatenate([[0.0], np.cumsum(np.abs(np.diff(self(s), axis=0)).max(axis=1))])

    def spread(self, step: float) -> tuple[FloatArray, FloatArray]:
        """Return parameters (m,) and configurations (m, n), including 0 and 1, with joint distances of at most `step` [rad]."""
        s, lengths = self._measured
        count = max(2, int(np.ceil(lengths[-1] / step)) + 1)
        even = np.interp(np.linspace(0.0, lengths[-1], count), lengths, s)
        even[0], even[-1] = 0.0, 1.0
        return even, self(even)

    def first_collision(self, is_free: IsFree, step: float) -> float | None:
        """Return the parameter of a configuration that is not free, with checks every `step` [rad]; None if there is none."""
        s, q = self.spread(step)
        order = list(coarse_to_fine(len(s)))
        for i, row in zip(order, q[order], strict=True):
            if not is_free(row):
                return float(s[i])
        return None

    def bezier(self, low: FloatArray, high: FloatArray) -> FloatArray:
        """Return the path between parameters `low` and `high` (m,), without a knot in between, as cubic Bezier pieces.

        Returns:
            Control points (m, 4, n), [rad].
        """
        both, count = np.concatenate([low, high]), len(low)
        q, slopes = self(both), self(both, 1)
        third = (high - low)[:, None] / 3.0
        control = np.empty((count, 4, q.shape[1]))
        control[:, 0], control[:, 3] = q[:count], q[count:]
        control[:, 1] = control[:, 0] + third * slopes[:count]
        control[:, 2] = control[:, 3] - third * slopes[count:]
        return control

    def length(self) -> float:
        """Return the length in joint space [rad]."""
        return float(np.linalg.norm(np.diff(self._points, axis=0), axis=1).sum())

    def points(self) -> FloatArray:
        """Return configurations (m, n) along the path, including its ends, about 0.05 rad of joint motion apart."""
        return self._points.copy()

    @cached_property
    def _points(self) -> FloatArray:
        return self.spread(0.05)[1]


def through(points: FloatArray, s: FloatArray | None = None) -> JointPath:
    """Return a smooth interpolation of points (m, n), at parameters `s` (m,) or at their distances."""
    points = np.asarray(points, dtype=np.float64)
    if s is None:
        points = distinct(points)
        s = _chord(points)
    if len(points) < 4:
        return along(points, radius=1.0)
    return JointPath(make_interp_spline(s, points, k=3))


def along(vertices: FloatArray, radius: float | FloatArray) -> JointPath:
    """Return a polyline (m, n) with corners rounded over at most `radius` [rad] before and after, one for all or one each (m,).

    The curve is a cubic B-spline whose control points are on the polyline. It stays in the hull of neighbouring points, so with
    a decreasing radius it converges to the polyline.
    """
    vertices = np.asarray(vertices)
    if np.ndim(radius) == 0 or len(vertices) != len(distinct(vertices)):
        vertices = distinct(vertices)
        radius = np.full(len(vertices), np.min(radius))
    control = _control_points(vertices, np.asarray(radius))
    chord = _chord(control)
    inner = (chord[1:-3] + chord[2:-2] + chord[3:-1]) / 3.0
    return JointPath(BSpline.construct_fast(np.concatenate([np.zeros(4), inner, np.ones(4)]), control, 3))


def _derivative(spline: BSpline) -> BSpline:
    """Return the derivative of a spline, bit-identical to `BSpline.derivative`, in a fifth of its time.

    Raises:
        ValueError: Inner knots are repeated.
    """
    knots, degree, count = spline.t, spline.k, len(spline.t) - spline.k - 1
    width = knots[degree + 1 : -1] - knots[1 : -degree - 1]
    if not width.all():
        raise ValueError("the spline has repeated inner knots, and cannot be differentiated there")
    control = (spline.c[1:count] - spline.c[: count - 1]) * degree / width[:, None]
    return BSpline.construct_fast(knots[1:-1], control, degree - 1)


def round_off(
    vertices: FloatArray,
    first_violation: Callable[[JointPath], float | None],
    *,
    repair: Callable[[FloatArray], FloatArray | None] = lambda vertices: vertices,
    radius: float = 0.4,
    least: float = 0.01,
) -> JointPath | None:
    """Round the corners of a polyline, each as much as the rules allow.

    Args:
        vertices: Corners (m, n), including the ends.
        first_violation: Function that returns the parameter (0..1) at which a path violates a rule, or None.
        repair: Function that is called at the first violation; it returns a polyline with free edges, or None.
        radius: Largest radius of rounding [rad].
        least: Smallest radius of rounding [rad].

    Returns:
        The curve, or None if the smallest radius violates a rule, or `repair` returned None.
    """
    vertices, repaired = distinct(vertices), False
    radii = np.full(len(vertices), radius)
    while True:
        path = along(vertices, radii)
        where = first_violation(path)
        if where is None:
            return path
        if not repaired:
            better, repaired = repair(vertices), True
            if better is None:
                return None
            if better is not vertices:
                vertices = distinct(better)
                radii = np.full(len(vertices), radius)
                continue
        corner = int(np.argmin(np.linalg.norm(vertices - path(where), axis=1)))
        if radii[corner] < 2.0 * least:
            return None
        radii[corner] *= 0.4


def distinct(points: FloatArray) -> FloatArray:
    """Remove points that repeat their predecessor; keep at least two."""
    keep = np.concatenate([[True], np.abs(np.diff(points, axis=0)).max(axis=1) > 1e-9])
    return points[keep] if keep.sum() > 1 else points[[0, -1]]


def edge_is_free(a: FloatArray, b: FloatArray, is_free: IsFree, step: float) -> bool:
    """Return whether the straight joint-space line from `a` to `b` is free without its ends, with checks every `step` [rad]."""
    way = b - a
    count = math.ceil(max(map(abs, way.tolist())) / step) + 1
    return count < 3 or all(map(is_free, a + _shares(count) * way))


@lru_cache(maxsize=1024)
def _shares(count: int) -> FloatArray:
    """Return the parameters (0..1) of the inner ones of `count` even samples of an edge (count - 2, 1), widely spaced first."""
    shares = np.array(coarse_to_fine(count)[2:])[:, None] / max(1, count - 1)
    shares.flags.writeable = False
    return shares


@lru_cache(maxsize=1024)
def coarse_to_fine(count: int) -> tuple[int, ...]:
    """Return 0..count-1, widely spaced indices first, so that collisions are found early."""
    order = [0, count - 1] if count > 1 else [0]
    stride = 1
    while stride < count:
        stride *= 2
    seen = set(order)
    while stride > 1:
        half = stride // 2
        for i in range(half, count - 1, stride):
            if i not in seen:
                seen.add(i)
                order.append(i)
        stride = half
    return tuple(order)


def _chord(points: FloatArray) -> FloatArray:
    """Return the distance along the points, scaled to 0..1."""
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    total = np.concatenate([[0.0], np.cumsum(lengths)])
    return total / total[-1] if total[-1] > 0.0 else np.linspace(0.0, 1.0, len(points))


def _control_points(vertices: FloatArray, radii: FloatArray) -> FloatArray:
    """Return control points on a polyline: its vertices, and two on each edge that bound the rounding of its corners."""
    way = np.diff(vertices, axis=0)
    lengths = np.maximum(np.linalg.norm(way, axis=1), 1e-12)
    after, before = (np.minimum(1.0 / 3.0, r / lengths)[:, None] for r in (radii[:-1], radii[1:]))
    rows = np.stack([vertices[:-1] + after * way, vertices[1:] - before * way, vertices[1:]], axis=1)
    return np.concatenate([vertices[:1], rows.reshape(-1, vertices.shape[1])])


STEP_POSITION = 0.02
"""Distance of the tip between two solved configurations [m]."""
STEP_ROTATION = 0.1
"""Angle of the tip between two solved configurations [rad]."""
MAX_STEPS = 5000
"""Maximum number of steps of a line or curve: 100 m, or 80 revolutions."""
LARGEST_JUMP = 0.4
"""Joint motion in one step above which the arm would flip its configuration [rad]."""


def straight_path(model: RobotModel, q_start: FloatArray, goal: PoseLike, is_free: IsFree | None = None) -> FloatArray:
    """Return configurations (m, n) whose tip moves straight, with even rotation, from its present pose to `goal` (7,).

    Raises:
        InvalidRequest: NaN, a wrong shape, or no numbers.
        OutsideJointLimits: The start is outside the joint limits.
        NotStraight: A joint limit, a singularity or a collision interrupts the line.
    """
    q_start, goal = as_configuration(model, q_start, "start configuration"), as_goal_pose(goal)
    _check_is_free(is_free)
    return _follow(model, q_start, _line(model.tip_se3(q_start), pose_to_se3(goal)), is_free)


def curve_path(model: RobotModel, q_start: FloatArray, poses: Sequence[PoseLike], is_free: IsFree | None = None) -> FloatArray:
    """Return configurations (m, n) whose tip passes through `poses` (7,) in order, on a smooth curve.

    Raises:
        InvalidRequest: NaN, a wrong shape, or no poses.
        OutsideJointLimits: As in `straight_path`.
        NotStraight: As in `straight_path`.
    """
    q_start, poses = as_configuration(model, q_start, "start configuration"), as_goal_poses(poses, "curve")
    _check_is_free(is_free)
    targets = _curve([model.tip_se3(q_start), *(pose_to_se3(pose) for pose in poses)])
    return _follow(model, q_start, targets, is_free)


def _check_is_free(is_free: object) -> None:
    if is_free is not None and not callable(is_free):
        raise InvalidRequest("is_free", is_free, "has to be a function of a configuration (n,), or None")


def _line(start: pin.SE3, goal: pin.SE3) -> list[pin.SE3]:
    """Return the poses after `start` up to `goal`, evenly spaced, position and orientation interpolated separately."""
    shift = goal.translation - start.translation
    turn = pin.log3(start.rotation.T @ goal.rotation)
    count = max(4, int(np.ceil(_checked_size(_size(start, goal)))))
    line = [pin.SE3(start.rotation @ pin.exp3(k / count * turn), start.translation + k / count * shift) for k in range(1, count)]
    return [*line, goal]


def _curve(stations: Sequence[pin.SE3]) -> list[pin.SE3]:
    """Return the poses after the first station on a smooth curve through all stations; a line if there are only two."""
    gaps = [_size(a, b) for a, b in pairwise(stations)]
    _checked_size(sum(gaps))
    stations = [stations[0], *(b for b, gap in zip(stations[1:], gaps, strict=True) if gap > 1e-3)]
    gaps = [gap for gap in gaps if gap > 1e-3]
    if len(stations) < 3:
        return _line(stations[0], stations[-1])
    at = np.concatenate([[0.0], np.cumsum(gaps)])
    positions = CubicSpline(at, np.array([T.translation for T in stations]))
    rotations = RotationSpline(at, Rotation.from_matrix(np.array([T.rotation for T in stations])))
    shares = [np.linspace(a, b, max(1, int(np.ceil(b - a))) + 1)[1:] for a, b in pairwise(at)]
    u = np.concatenate(shares)
    return [pin.SE3(R, x) for R, x in zip(rotations(u).as_matrix(), positions(u), strict=True)]


def _size(a: pin.SE3, b: pin.SE3) -> float:
    """Return the number of steps between two poses."""
    turn = np.linalg.norm(pin.log3(a.rotation.T @ b.rotation))
    return float(max(np.linalg.norm(b.translation - a.translation) / STEP_POSITION, turn / STEP_ROTATION))


def _checked_size(steps: float) -> float:
    if not steps <= MAX_STEPS:
        raise NotStraight(0.0, f"it is {steps * STEP_POSITION:.4g} m long, or turns as much, and the arm ends before")
    return steps


def _follow(model: RobotModel, q_start: FloatArray, targets: Sequence[pin.SE3], is_free: IsFree | None) -> FloatArray:
    """Solve for each target in order, from a guess that extrapolates the last step."""
    q, last = np.array(q_start), np.array(q_start)
    path = [q]
    for k, target in enumerate(targets):
        end = descend(model, target, 2.0 * q - last, iterations=12)
        if not end.converged:
            raise NotStraight(k / len(targets), "the arm cannot reach on, a joint limit or the end of its reach is met")
        if np.abs(end.q - q).max() > LARGEST_JUMP:
            raise NotStraight(k / len(targets), "the arm would have to flip, it is close to a singular configuration")
        if is_free is not None and k < len(targets) - 1 and not is_free(end.q):
            raise NotStraight(k / len(targets), "something is in the way")
        last, q = q, end.q
        path.append(q)
    return np.array(path)
