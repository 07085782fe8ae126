"""Timing: a geometric path becomes a trajectory that is as fast as the joint limits allow, by TOPPRA."""

from __future__ import annotations

import logging

import numpy as np
import toppra
import toppra.constraint

from rlbench_pin.errors import InvalidRequest, RetimingError
from rlbench_pin.planning.path import JointPath, through
from rlbench_pin.planning.timing.arc import ArcLimits
from rlbench_pin.planning.timing.constraint import MotionConstraint
from rlbench_pin.planning.timing.passes import fastest_speeds
from rlbench_pin.planning.timing.torque import TorqueLimits
from rlbench_pin.robot.model import JointLimits
from rlbench_pin.robot.trajectory import Trajectory
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_number, as_record, as_rows, as_vector

SAMPLE_DT = 1.0 / 240.0
"""Longest time between two samples of the trajectory [s]."""
GRID_STEP = 0.04
"""Joint distance between grid points of the timing problem [rad]."""
LONGEST = 3600.0
"""Motions that take longer are refused: they have too many samples [s]."""
LARGEST_LENGTH = 1e4
"""Paths that are longer, the joints added up, are refused [rad]."""
SHORT = 3e-3
"""Paths shorter than this in joint space are timed by a cubic polynomial [rad]."""
_GRID_RANGE = (40, 160)
_FINER = (1, 2, 3, 5)
"""How many times finer the grids are that are tried in turn."""
_HALT = 5e-3
"""A point passed at less than this share of the greatest speed is a halt."""
_RESERVE = 0.98
"""Share of the limits that is used at grid points, because between them they are passed by a little."""
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
        path: Smooth path, or way configurations (m, n), [rad], which are interpolated.
        limits: Velocity [rad/s] and acceleration [rad/s^2] bounds of each joint.
        arc: Limits along the joint-space arc, beside those of the joints; None for none.
        torque: Dynamics and torque limits [N m]; None for no such limits.
        jerk_time: How long a change of acceleration takes at least [s]; 0 lets it jump. The motion takes that much longer.

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
    """Return what is to be timed as a smooth path, when path and limits belong together."""
    if not isinstance(limits, JointLimits):
        raise InvalidRequest("limits", limits, "has to be JointLimits", "`model.limits` are those of an arm.")
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
            "The path", path, f"is {length:.4g} rad long, all joints together; {LARGEST_LENGTH:g} rad are possible"
        )
    return through(points)


def _checked_duration(seconds: float) -> float:
    if not seconds <= LONGEST:
        raise RetimingError(f"the motion would take {seconds:.4g} s, and {LONGEST:g} s are possible; raise the limits")
    return seconds


def _timed(
    path: JointPath,
    constraints: list[toppra.constraint.Constraint],
    limits: JointLimits,
    arc: ArcLimits | None,
    jerk_time: float,
) -> Trajectory:
    """Solve and sample."""
    grid, speeds = _solve_without_halt(path, constraints)
    profile = _sample(grid, speeds) if jerk_time <= 0.0 else _eased(grid, speeds, jerk_time)
    tangents = path(profile[1], 1)
    samples = _along(path, profile, tangents)
    excess = 0.0 if arc is None else arc.excess(tangents, *samples[2:])
    return _slowed(samples, limits, excess)


def _solve_without_halt(path: JointPath, constraints: list[toppra.constraint.Constraint]) -> tuple[FloatArray, FloatArray]:
    """Return grid points and ds/dt there, each (m,), on the coarsest grid that is fine enough.

    Where a path bends sharply between two grid points, TOPPRA's forward pass may find no way on but to stand almost still at a
    point that could be passed quickly. A finer grid cures that.
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
    """Place grid points midway between evenly in s and evenly in joint distance, `finer` times as many as usual."""
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
    """Return times, s, ds/dt, d2s/dt2 before and after each sample; samples at every grid point, at most `SAMPLE_DT` apart."""
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
    """As `_sample`, averaged over the last `width` seconds: s(t) = (S(t) - S(t - width)) / width, with S the integral of s."""
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
    """Build the trajectory, uniformly slower where a limit would be passed between grid points, or `excess` asks for it."""
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
