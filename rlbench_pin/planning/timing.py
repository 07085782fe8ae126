"""Time-optimal timing of a geometric path within the limits of joints, motors and the joint-space arc, by TOPPRA.

With the path q(s), u = d2s/dt2 and x = (ds/dt)^2, joint accelerations are q' u + q'' x. The speed along the arc is |q'| sqrt(x),
and its rate of change is d|dq/dt|/dt = (q' . ddq) / |q'| = |q'| u + (q' . q'') / |q'| x. All are linear in (u, x), as TOPPRA
requires.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rlbench_pin.errors import InvalidRequest, RetimingError
from rlbench_pin.planning.path import JointPath, through
from rlbench_pin.planning.toppra_import import seidelWrapper, toppra
from rlbench_pin.robot.model import LARGEST, JointLimits, RobotModel, loaded
from rlbench_pin.robot.trajectory import Trajectory
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_number, as_record, as_rows, as_vector

_TINY = 1e-12


@dataclass(frozen=True)
class ArcLimits:
    """Limits along the joint-space arc of a motion, in addition to those of the joints."""

    velocity: float
    """Largest norm of the joint velocity [rad/s]."""
    acceleration: float
    """Largest change of that norm [rad/s^2]."""

    def __post_init__(self) -> None:
        """Raise InvalidRequest unless both are > 0."""
        for name in ("velocity", "acceleration"):
            as_number(getattr(self, name), f"ArcLimits.{name}", InvalidRequest, above=0.0, finite=False)

    def excess(self, tangents: FloatArray, v: FloatArray, before: FloatArray, after: FloatArray) -> float:
        """Return the factor by which a motion must be slower to keep the limits; at most 1 if it keeps them.

        Args:
            tangents: Directions of the path at the samples, of any length, shape (m, n).
            v: Joint velocities, shape (m, n), [rad/s].
            before: Joint accelerations before each sample, shape (m, n), [rad/s^2].
            after: Joint accelerations after each sample.
        """
        along = tangents / np.maximum(np.linalg.norm(tangents, axis=1, keepdims=True), _TINY)
        change = max(float(np.abs((a * along).sum(axis=1)).max()) for a in (before, after))
        return max(float(np.linalg.norm(v, axis=1).max()) / self.velocity, float(np.sqrt(change / self.acceleration)))

    def shortest(self, way: FloatArray) -> float:
        """Return the shortest duration of a straight motion of `way` (n,) [rad], with q = way (3 x^2 - 2 x^3), x = t / T [s]."""
        length = float(np.linalg.norm(way))
        return max(1.5 * length / self.velocity, float(np.sqrt(6.0 * length / self.acceleration)))


DENSE = 1e-3
"""Time between two evaluations of the torques of a finished trajectory [s]."""
_SAMPLE_STEP = 0.05
"""Maximum time [s] and joint distance [rad] between samples of the fast bound."""
_COARSE_STEP, _COARSE_SHARE = 0.2, 0.88
"""Maximum time and distance of a coarse check, which suffices if torques stay below this fraction of the limits: on 100 motions
the largest torque between such samples was 0.5 % of a limit above the largest at them."""
_TORQUE_RESERVE = 0.97
_ROUNDS = 12


class TorqueLimits:
    """The dynamics of one arm with a payload, and its torque limits."""

    def __init__(self, model: RobotModel, payload: pin.Inertia | None = None) -> None:
        """Copy the dynamics of the arm, so that a payload does not change the model.

        Args:
            model: The arm.
            payload: Payload in the frame of the last joint; None for no payload.
        """
        as_record(model, RobotModel, "model")
        self._arm = pin.Model(model.arm)
        self._last, self._bare = model.size, model.arm.inertias[model.size].copy()
        self.limit = model.limits.effort
        self.carry(payload)

    def carry(self, payload: pin.Inertia | None) -> None:
        """Replace the payload."""
        payload = pin.Inertia.Zero() if payload is None else as_record(payload, pin.Inertia, "payload")
        self._arm.inertias[self._last] = loaded(self._bare, payload)
        self._data = self._arm.createData()

    def torques(self, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
        """Return the torques (n,) of one instant [N m].

        Raises:
            InvalidValue: NaN, a wrong shape, or no numbers (also a ValueError).
        """
        q, v, a = (as_vector(x, self._last, what, most=LARGEST) for x, what in ((q, "q"), (v, "v"), (a, "a")))
        return np.array(pin.rnea(self._arm, self._data, q, v, a))

    def constraint(self) -> toppra.constraint.Constraint:
        """Return the limits as a constraint of TOPPRA."""
        bound = _TORQUE_RESERVE * np.stack([-self.limit, self.limit], axis=1)
        scheme = toppra.constraint.DiscretizationType.Interpolation
        friction = np.zeros(len(self.limit))
        return toppra.constraint.JointTorqueConstraint(self.torques, bound, friction, discretization_scheme=scheme)

    def surely_kept(self, trajectory: Trajectory, acceleration: FloatArray) -> bool:
        """Return whether all accelerations within +-`acceleration` (n,) keep the limits on the path; fast and conservative."""
        as_record(trajectory, Trajectory, "trajectory")
        acceleration = as_vector(acceleration, self._last, "acceleration")
        return any(
            self._within(trajectory, acceleration, look, share * self.limit)
            for look, share in ((_COARSE_STEP, _COARSE_SHARE), (_SAMPLE_STEP, _TORQUE_RESERVE))
        )

    def _within(self, trajectory: Trajectory, acceleration: FloatArray, look: float, limit: FloatArray) -> bool:
        """Return whether this holds for torques `limit` (n,) [N m] at samples about `look` [s] or [rad] apart."""
        which = _spaced(trajectory, look)
        rest, upper = np.empty((len(which), len(limit))), np.empty((len(which), len(limit), len(limit)))
        for k, (q, v) in enumerate(zip(trajectory.q[which], trajectory.v[which], strict=True)):
            rest[k] = pin.nonLinearEffects(self._arm, self._data, q, v)
            upper[k] = pin.crba(self._arm, self._data, q)
        upper = np.triu(np.abs(upper))
        inertia = upper + np.triu(upper, 1).swapaxes(1, 2)
        return not bool((np.abs(rest) + inertia @ acceleration > limit).any())

    def worst(self, trajectory: Trajectory, dt: float = DENSE) -> float:
        """Return the largest |tau| / limit, evaluated every `dt` [s] and at each sample."""
        duration = as_record(trajectory, Trajectory, "trajectory").duration
        as_number(dt, "dt [s]", least=duration * 1e-7, above=0.0)
        times = np.unique(np.concatenate([np.arange(0.0, trajectory.duration, dt), trajectory.times]))
        ratios = [np.abs(self.torques(*trajectory.sample(t))) / self.limit for t in times]
        return float(np.max(ratios))

    def slowed(self, trajectory: Trajectory) -> Trajectory:
        """Return the trajectory, uniformly slower if that is necessary to keep the limits everywhere.

        A lower speed does not reduce gravity torques: for a payload beyond the torque limits, the speed is reduced to 1/10.
        """
        for _ in range(_ROUNDS):
            ratio = self.worst(trajectory)
            if ratio <= 1.0:
                return trajectory
            trajectory = stretched(trajectory, min(1.25, 1.0 + max(0.002, 0.7 * (ratio - 1.0))))
        return trajectory


def _spaced(trajectory: Trajectory, look: float) -> NDArray[np.intp]:
    """Return samples of a trajectory about `look` apart in time, or along the path if that is closer."""
    steps = np.maximum(np.diff(trajectory.times), np.abs(np.diff(trajectory.q, axis=0)).max(axis=1)) / look
    return np.flatnonzero(np.diff(np.floor(np.concatenate([[-1.0, 0.0], np.cumsum(steps)]))))


def stretched(trajectory: Trajectory, factor: float) -> Trajectory:
    """Return the trajectory `factor` times slower."""
    return Trajectory(trajectory.times * factor, trajectory.q, trajectory.v / factor, trajectory.a / factor**2)


_UNBOUNDED = 1e8
"""Bound of (ds/dt)^2 where nothing moves."""


class MotionConstraint(toppra.constraint.LinearConstraint):
    """A fraction of all limits in one constraint, so that the path is evaluated once."""

    def __init__(self, limits: JointLimits, arc: ArcLimits | None, share: float) -> None:
        """Prepare the bounds.

        Args:
            limits: Velocity [rad/s] and acceleration [rad/s^2] bounds of each joint.
            arc: Limits along the joint-space arc; None for none.
            share: Usable fraction of all limits.
        """
        super().__init__()
        self.identical, self.dof = True, len(limits.velocity)
        self._arc, self._share = arc, share
        self._velocity = share * limits.velocity
        most = share * limits.acceleration
        bounds = np.concatenate([most, most] if arc is None else [most, [share * arc.acceleration]] * 2)
        self._sides = np.concatenate([np.eye(len(bounds)), -np.eye(len(bounds))])
        self._bounds = np.concatenate([bounds, bounds])

    def compute_constraint_params(
        self, path: toppra.interpolator.AbstractGeometricPath, gridpoints: FloatArray
    ) -> tuple[FloatArray | None, ...]:
        """Return a, b, c, F, g, bounds of u and bounds of x: F (a u + b x + c) <= g."""
        a, b = path(gridpoints, 1), path(gridpoints, 2)
        fastest = np.min((self._velocity / np.maximum(np.abs(a), _TINY)) ** 2, axis=1)
        if self._arc is not None:
            rates = np.maximum(np.linalg.norm(a, axis=1), _TINY)
            bends = (a * b).sum(axis=1) / rates
            fastest = np.minimum(fastest, (self._share * self._arc.velocity / rates) ** 2)
            a, b = np.column_stack([a, rates]), np.column_stack([b, bends])
        ends, bends_there = np.concatenate([a[1:], a[-1:]]), np.concatenate([b[1:], b[-1:]])
        widths = np.append(np.diff(gridpoints), 0.0)[:, None]
        u = np.concatenate([a, ends + 2.0 * widths * bends_there], axis=1)
        x = np.concatenate([b, bends_there], axis=1)
        between = np.stack([np.zeros_like(fastest), np.minimum(fastest, _UNBOUNDED)], axis=1)
        return u, x, np.zeros_like(u), self._sides, self._bounds, None, between


_NAN = math.nan
_TINY_SPEED, _RETRIES = 1e-8, 10
_SLOWEST_START = 1e-5
"""Tolerance above 0 of the smallest (ds/dt)^2 at the start."""
_MINIMIZE, _MAXIMIZE = np.array([-1e-9, 1.0]), np.array([1e-9, -1.0])


def fastest_speeds(
    constraints: Sequence[toppra.constraint.Constraint],
    path: toppra.interpolator.AbstractGeometricPath,
    grid: FloatArray,
) -> FloatArray | None:
    """Return ds/dt (m,) at grid points (m,), at rest at both ends; None if the end cannot be reached at rest.

    These are the two passes of TOPP-RA (Pham, Pham 2018) over its own linear programs, without the overhead of its driver.
    x_(i+1) = x_i + 2 (s_(i+1) - s_i) u_i: the backward pass computes the range of x at each grid point from which the end can be
    reached at rest; the forward pass takes the largest x in this range. The results are bit-identical to
    `toppra.algorithm.TOPPRA`.
    """
    solver = seidelWrapper(list(constraints), path, grid, solve_lp1d=True)
    ranges = _ranges(solver, len(grid) - 1, _can_rest(solver))
    return None if ranges is None or ranges[0][0] > _SLOWEST_START else _forward(solver, ranges)


def _can_rest(solver: seidelWrapper) -> bool:
    """Return whether u = x = 0 satisfies the constraints everywhere: F c <= g."""
    return all(c is None or (not c.any() and bool(np.all(g >= 0.0))) for _, _, c, _, g, _, _ in solver.params)


def _ranges(solver: seidelWrapper, steps: int, can_rest: bool) -> list[tuple[float, float]] | None:
    """Return the smallest and the largest x at each grid point from which the end can be reached at rest, or None."""
    solve, low, high = solver.solve_stagewise_optim, 0.0, 0.0
    ranges = [(low, high)]
    for i in range(steps - 1, -1, -1):
        largest = solve(i, None, _MAXIMIZE, _NAN, _NAN, low, high)[1]
        least = 0.0 if can_rest else solve(i, None, _MINIMIZE, _NAN, _NAN, low, high)[1]
        low, high = max(0.0, least), largest
        if math.isnan(least) or math.isnan(high):
            return None
        ranges.append((low, high))
    ranges.reverse()
    return ranges


def _forward(solver: seidelWrapper, ranges: list[tuple[float, float]]) -> FloatArray | None:
    """Return the largest ds/dt (m,) within the ranges of x; None after a numerical failure."""
    solve, deltas, xs, tries, i = solver.solve_stagewise_optim, solver.get_deltas().tolist(), [0.0], 0, 0
    goals = np.array([[-2.0 * delta, -1.0] for delta in deltas])
    while i < len(deltas):
        x, (low, high) = xs[i], ranges[i + 1]
        u = solve(i, None, goals[i], x, x, low, high)[0]
        if math.isnan(u):
            if tries == _RETRIES:
                return None
            xs[i], tries = max(x - _TINY_SPEED, 0.999 * x), tries + 1
            continue
        x, tries = x + 2.0 * deltas[i] * u, 0
        xs.append(min(high, max(low, max(x - _TINY_SPEED, 0.9999 * x))))
        i += 1
    return np.sqrt(xs)


SAMPLE_DT = 1.0 / 240.0
"""Longest time between two samples of the trajectory [s]."""
GRID_STEP = 0.04
"""Joint distance between grid points of the timing problem [rad]."""
LONGEST = 3600.0
"""Maximum duration of a motion [s]; longer ones have too many samples."""
LARGEST_LENGTH = 1e4
"""Maximum length of a path, as the sum over the joints [rad]."""
SHORT = 3e-3
"""Length in joint space below which a path is timed by a cubic polynomial [rad]."""
_GRID_RANGE = (40, 160)
_FINER = (1, 2, 3, 5)
"""Refinement factors of the grids, in the order of the attempts."""
_HALT = 5e-3
"""Fraction of the largest speed below which a point of the path is a halt."""
_RESERVE = 0.98
"""Usable fraction of the limits at grid points, because motions slightly exceed it between them."""
logging.getLogger("toppra").addHandler(logging.NullHandler())


class _ToppraPath(toppra.interpolator.AbstractGeometricPath):
    """A `JointPath` with the interface of TOPPRA."""

    def __init__(self, path: JointPath) -> None:
        self._path = path

    def __call__(self, s: FloatArray, order: int = 0) -> FloatArray:
        return self._path(s, order)

    @property
    def dof(self) -> int:
        return len(self._path.start)

    @property
    def path_interval(self) -> FloatArray:
        return np.array([0.0, 1.0])

    @property
    def waypoints(self) -> None:
        return None


def retime(
    path: JointPath | FloatArray,
    limits: JointLimits,
    *,
    arc: ArcLimits | None = None,
    torque: TorqueLimits | None = None,
    jerk_time: float = 0.0,
) -> Trajectory:
    """Time a joint path as fast as its limits allow, at rest at both ends.

    Args:
        path: Smooth path, or configurations (m, n), [rad], to interpolate.
        limits: Velocity [rad/s] and acceleration [rad/s^2] bounds of each joint.
        arc: Limits along the joint-space arc, in addition to those of the joints; None for none.
        torque: Dynamics and torque limits [N m]; None for no torque limits.
        jerk_time: Minimum duration of a change of acceleration [s]; 0 allows jumps. The motion takes this time longer.

    Raises:
        InvalidRequest: NaN, a wrong shape, no numbers, or a limit that is not > 0.
        RetimingError: No timing satisfies the limits, or the motion would take longer than `LONGEST`.
    """
    for given, kind, what in ((arc, ArcLimits, "arc"), (torque, TorqueLimits, "torque")):
        if given is not None:
            as_record(given, kind, what, InvalidRequest)
    smooth = _checked_path(path, limits)
    as_number(jerk_time, "jerk_time", InvalidRequest, least=0.0, most=LONGEST)
    length = smooth.length()
    if length < SHORT:
        return _short_motion(smooth.start, smooth.end, limits, arc)
    constraints: list[toppra.constraint.Constraint] = [MotionConstraint(limits, arc, _RESERVE)]
    trajectory = _timed(smooth, constraints, limits, arc, jerk_time)
    if torque is None or torque.surely_kept(trajectory, limits.acceleration) or torque.worst(trajectory) <= 1.0:
        return trajectory
    try:
        trajectory = _timed(smooth, [*constraints, torque.constraint()], limits, arc, jerk_time)
    except RetimingError:
        logging.getLogger(__name__).debug("no timing keeps the torque limits; the motion is slowed down as a whole")
    return torque.slowed(trajectory)


def _checked_path(path: JointPath | FloatArray, limits: JointLimits) -> JointPath:
    """Return the path to time as a smooth path, after checks of path and limits."""
    if not isinstance(limits, JointLimits):
        raise InvalidRequest("limits", limits, "has to be JointLimits", "Pass `model.limits` of an arm.")
    if min(limits.velocity.min(), limits.acceleration.min()) <= 0.0:
        raise InvalidRequest("limits", limits, "has to have velocities and accelerations > 0")
    size = len(limits.lower)
    if isinstance(path, JointPath):
        as_vector(path.start, size, "The start of the path", InvalidRequest)
        return path
    points = as_rows(path, size, "The path", InvalidRequest)
    length = float(np.abs(np.diff(points, axis=0)).sum())
    if not length <= LARGEST_LENGTH:
        raise InvalidRequest(
            "The path", path, f"is {length:.4g} rad long, all joints together; the maximum is {LARGEST_LENGTH:g} rad"
        )
    return through(points)


def _checked_duration(seconds: float) -> float:
    if not seconds <= LONGEST:
        raise RetimingError(f"the motion would take {seconds:.4g} s, the maximum is {LONGEST:g} s; raise the limits")
    return seconds


def _timed(
    path: JointPath,
    constraints: list[toppra.constraint.Constraint],
    limits: JointLimits,
    arc: ArcLimits | None,
    jerk_time: float,
) -> Trajectory:
    """Solve for the timing and sample it."""
    grid, speeds = _solve_without_halt(path, constraints)
    profile = _sample(grid, speeds) if jerk_time <= 0.0 else _eased(grid, speeds, jerk_time)
    tangents = path(profile[1], 1)
    samples = _along(path, profile, tangents)
    excess = 0.0 if arc is None else arc.excess(tangents, *samples[2:])
    return _slowed(samples, limits, excess)


def _solve_without_halt(path: JointPath, constraints: list[toppra.constraint.Constraint]) -> tuple[FloatArray, FloatArray]:
    """Return grid points and ds/dt there, each (m,), on the coarsest sufficient grid.

    If a path bends sharply between two grid points, the forward pass of TOPPRA may almost halt at a point that allows a high
    speed. A finer grid avoids this.
    """
    best: tuple[float, FloatArray, FloatArray] | None = None
    for finer in _FINER:
        grid = _grid(path, finer)
        try:
            speeds = _solve(path, grid, constraints)
        except RetimingError:
            if finer == _FINER[-1] and best is None:
                raise
            continue
        duration = _checked_duration(float((2.0 * np.diff(grid) / (speeds[:-1] + speeds[1:])).sum()))
        if best is None or duration < best[0]:
            best = duration, grid, speeds
        if speeds[1:-1].min() >= _HALT * speeds.max():
            break
    assert best is not None
    return best[1:]


def _grid(path: JointPath, finer: int = 1) -> FloatArray:
    """Return grid points midway between even spacing in s and in joint distance, `finer` times the usual number."""
    s, q = path.spread(GRID_STEP)
    length = float(np.abs(np.diff(q, axis=0)).max(axis=1).sum())
    count = finer * int(np.clip(length / GRID_STEP, *_GRID_RANGE)) + 1
    along = np.interp(np.linspace(0.0, 1.0, count), np.linspace(0.0, 1.0, len(s)), s)
    grid = 0.5 * (along + np.linspace(0.0, 1.0, count))
    grid[0], grid[-1] = 0.0, 1.0
    return grid


def _solve(path: JointPath, grid: FloatArray, constraints: list[toppra.constraint.Constraint]) -> FloatArray:
    """Return ds/dt (m,) at the grid points."""
    speeds = fastest_speeds(constraints, _ToppraPath(path), grid)
    if speeds is None or not np.all(np.isfinite(speeds)):
        raise RetimingError("the end cannot be reached at rest within the limits")
    if np.any(speeds[:-1] + speeds[1:] <= 0.0):
        raise RetimingError("the path comes to a halt on its way")
    return speeds


def _sample(grid: FloatArray, speeds: FloatArray) -> tuple[FloatArray, ...]:
    """Return times, s, ds/dt, d2s/dt2 before and after each sample; samples are at all grid points, at most `SAMPLE_DT` apart."""
    width = np.diff(grid)
    durations = 2.0 * width / (speeds[:-1] + speeds[1:])
    accelerations = 0.5 * np.diff(speeds**2) / width
    counts = np.maximum(1, np.ceil(durations / SAMPLE_DT)).astype(int)
    cell = np.repeat(np.arange(len(counts)), counts)
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    local = durations[cell] * within / counts[cell]
    starts = np.concatenate([[0.0], np.cumsum(durations)])
    times = np.append(starts[cell] + local, starts[-1])
    s = np.append(grid[cell] + speeds[cell] * local + 0.5 * accelerations[cell] * local**2, 1.0)
    s_dot = np.append(speeds[cell] + accelerations[cell] * local, speeds[-1])
    after = np.append(accelerations[cell], accelerations[-1])
    return times, s, s_dot, np.concatenate([after[:1], after[:-1]]), after


def _eased(grid: FloatArray, speeds: FloatArray, width: float) -> tuple[FloatArray, ...]:
    """Return `_sample` averaged over the last `width` seconds: s(t) = (S(t) - S(t - width)) / width, S the integral of s."""
    cells = np.diff(grid)
    durations = 2.0 * cells / (speeds[:-1] + speeds[1:])
    accelerations = 0.5 * np.diff(speeds**2) / cells
    starts = np.concatenate([[0.0], np.cumsum(durations)])
    integrals = grid[:-1] * durations + speeds[:-1] * durations**2 / 2.0 + accelerations * durations**3 / 6.0
    sums = np.concatenate([[0.0], np.cumsum(integrals)])

    def at(t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return S, s and ds/dt, at rest before the beginning and after the end."""
        inside = np.clip(t, 0.0, starts[-1])
        i = np.clip(np.searchsorted(starts, inside, side="right") - 1, 0, len(cells) - 1)
        x = inside - starts[i]
        s_dot = speeds[i] + accelerations[i] * x
        s = grid[i] + speeds[i] * x + accelerations[i] * x**2 / 2.0
        area = sums[i] + grid[i] * x + speeds[i] * x**2 / 2.0 + accelerations[i] * x**3 / 6.0
        return area + np.maximum(t - starts[-1], 0.0), s, np.where((t < 0.0) | (t > starts[-1]), 0.0, s_dot)

    end = starts[-1] + width
    times = np.linspace(0.0, end, int(np.ceil(end / SAMPLE_DT)) + 1)
    now, before = at(times), at(times - width)
    s, s_dot, s_ddot = ((a - b) / width for a, b in zip(now, before, strict=True))
    s[0], s[-1] = 0.0, 1.0
    return times, np.clip(s, 0.0, 1.0), s_dot, s_ddot, s_ddot


def _along(path: JointPath, profile: tuple[FloatArray, ...], tangents: FloatArray) -> tuple[FloatArray, ...]:
    """Return times, q, v, a (before and after each sample) of a profile along the path, with dq/ds at its samples."""
    times, s, s_dot, before, after = profile
    bend = path(s, 2) * (s_dot**2)[:, None]
    return times, path(s), tangents * s_dot[:, None], bend + tangents * before[:, None], bend + tangents * after[:, None]


def _slowed(samples: tuple[FloatArray, ...], limits: JointLimits, excess: float) -> Trajectory:
    """Build the trajectory, uniformly slower if it exceeds a limit between grid points, or if `excess` requires it."""
    times, q, v, before, after = samples
    most = np.maximum(np.abs(before), np.abs(after))
    excess = max(excess, float((np.abs(v) / limits.velocity).max()), float(np.sqrt((most / limits.acceleration).max())))
    factor = max(1.0, excess * 1.001)
    return Trajectory(times * factor, q, v / factor, after / factor**2)


def _short_motion(start: FloatArray, end: FloatArray, limits: JointLimits, arc: ArcLimits | None) -> Trajectory:
    """Time a motion too short for TOPPRA: q = start + (3 x^2 - 2 x^3) (end - start), x = t / T."""
    way = end - start
    slowest = max(
        float((1.5 * np.abs(way) / limits.velocity).max()), float(np.sqrt((6.0 * np.abs(way) / limits.acceleration).max()))
    )
    slowest = slowest if arc is None else max(slowest, arc.shortest(way))
    _checked_duration(slowest)
    if slowest < 1e-6:
        rest = np.zeros((1, len(end)))
        return Trajectory(np.zeros(1), end[None].copy(), rest, rest.copy())
    duration = 1.001 * slowest
    x = np.linspace(0.0, 1.0, 9)[:, None]
    return Trajectory(
        duration * x[:, 0],
        start + (3.0 * x**2 - 2.0 * x**3) * way,
        (6.0 * x - 6.0 * x**2) * way / duration,
        (6.0 - 12.0 * x) * way / duration**2,
    )
