"""The hand between looking and moving: it checks what it can reach before it goes, and watches how far it has come."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pinocchio as pin

from rlbench_pin.errors import PlanningError
from rlbench_pin.evaluation.baselines.classical.errors import NothingFound
from rlbench_pin.evaluation.baselines.classical.perception import View, look
from rlbench_pin.evaluation.baselines.classical.skills.driver import Driver
from rlbench_pin.observation import Observation
from rlbench_pin.planning import straight_path
from rlbench_pin.robot.trajectory import Trajectory
from rlbench_pin.spatial import FloatArray, se3_to_pose

SPEED, TURNING = 0.2, 1.0
"""Of the tip where it slides [m/s], [rad/s]."""
PACES = 4
"""A sliding tip reaches its speed in so many ticks, and stops in about as many."""
LAG = 0.015
"""The next station waits until the tip is nearer than this [m]; an angle of 1 rad counts as much as 0.1 m."""
THERE = 0.002
"""Nearer than this is there [m]."""
PATIENCE = 8
"""How long a motion may stand still before it is given up [ticks]."""
PLANS = 4
"""Of so many ways a free motion to the begin is looked for."""


@dataclass(frozen=True, eq=False)
class Tick:
    """One action: how fast the joints turn, and what the fingers do then."""

    velocity: FloatArray
    """Joint velocities (n,) [rad/s]."""
    is_open: bool
    """Whether the fingers are open at the end."""


Moves = Generator[Tick, Observation, None]
"""What a skill is: it yields actions and is sent what is seen after each."""


@dataclass(frozen=True, eq=False)
class Way:
    """Placements of the tip that the arm can follow, and a free motion to the first."""

    targets: Sequence[pin.SE3]
    """One after the other."""
    motion: Trajectory
    """From where the arm is to the first."""


class Hand:
    """The arm with its hand as a skill sees it: what was observed last, and what it may reach from there."""

    def __init__(self, driver: Driver, observation: Observation, rng: np.random.Generator) -> None:
        """Begin with what is seen at the start of an episode."""
        self.seen, self._driver, self._rng = observation, driver, rng
        self.is_open = True
        self._arm, self._still = driver.arm, np.zeros(driver.arm.size)
        self._view: tuple[Observation, View] | None = None
        self._home = self.joints

    def look(self) -> View:
        """Return what the last observation shows."""
        if self._view is None or self._view[0] is not self.seen:
            self._view = self.seen, look(self.seen, self._arm)
        return self._view[1]

    @property
    def joints(self) -> FloatArray:
        """Where the joints of the arm are (n,), brought within their limits [rad]."""
        measured = np.asarray(self.seen.joint_positions, dtype=float)
        return np.clip(measured, self._arm.limits.lower, self._arm.limits.upper)

    @property
    def tip(self) -> pin.SE3:
        """Where the tip is."""
        return self._arm.tip_se3(self.joints)

    # Moving -------------------------------------------------------------------------------------------------------

    def go(self, way: Way, is_open: bool | None = None) -> Moves:
        """Open or close the fingers, or leave them when None; then move freely to the first placement of a way."""
        yield from self.grip(is_open)
        yield from self._follow(way.motion)

    def go_home(self) -> Moves:
        """Move freely to where the episode began."""
        self._driver.update(self.look().things, self.joints, self._fingers)
        yield from self._follow(self._driver.plan(self.joints, self._home, self._rng)[0])

    def slide(self, targets: Sequence[pin.SE3], speed: float = SPEED) -> Moves:
        """Move the tip straight from one placement to the next; wait where it is held back, and give up in time."""
        share = self._driver.period / PACES
        legs = pairwise([self.tip, *targets])
        stations = [station for a, b in legs for station in line(a, b, share * speed, share * TURNING)]
        v, k, pace, late, last = self._still, -1, 0, 0, len(stations) - 1
        while late < PATIENCE:
            if k < last and (k < 0 or apart(self.tip, stations[k]) < LAG):
                pace, late = min(pace + 1, PACES, 1 + (last - k) // PACES), 0
                k = min(k + pace, last)
            else:
                pace, late = 0, late + 1
            v = self._driver.towards(self.joints, v, stations[k])
            yield from self._tick(v)
            if k == last and apart(self.tip, stations[last]) < THERE:
                return

    def shift(self, by: Iterable[float]) -> Moves:
        """Move the tip by a vector (3,) of the world [m]."""
        here = self.tip
        yield from self.slide([pin.SE3(here.rotation, here.translation + np.array(list(by)))])

    def grip(self, is_open: bool | None) -> Moves:
        """Open or close the fingers where the hand is."""
        if is_open is not None and is_open != self.is_open:
            self.is_open = is_open
            yield from self._tick(self._still)

    def rest(self, ticks: int) -> Moves:
        """Stay for some ticks."""
        for _ in range(ticks):
            yield from self._tick(self._still)

    def _follow(self, motion: Trajectory) -> Moves:
        """Follow a timed motion until it is over and the joints have arrived."""
        follower, v, late = self._driver.follower(motion), self._still, 0
        while late < PATIENCE:
            v = follower.command(self.joints, v)
            yield from self._tick(v)
            late += follower.done
            if follower.done and np.abs(self.joints - motion.q[-1]).max() < THERE:
                return

    def _tick(self, velocity: FloatArray) -> Moves:
        self.seen = yield Tick(velocity, self.is_open)

    # Choosing -----------------------------------------------------------------------------------------------------

    def choose(self, ways: Sequence[Sequence[pin.SE3]]) -> Way:
        """Return the way that the arm can follow farthest; of several, one whose begin is reached without touching anything,
        with the least joint motion.
        """
        self._driver.update(self.look().things, self.joints, self._fingers)
        scored = sorted(((*self._follows(way), k) for k, way in enumerate(ways)), key=lambda s: (-s[0], not s[1], s[2], s[4]))
        best: Way | None = None
        for legs, _, _, start, k in scored[:PLANS]:
            if start is None or legs < scored[0][0]:
                break
            motion, is_free = self._driver.plan(self.joints, start, self._rng)
            if is_free or best is None:
                best = Way(ways[k], motion)
            if is_free:
                break
        if best is None:
            raise NothingFound("The arm reaches nothing of what it should.")
        return best

    def _follows(self, way: Sequence[pin.SE3]) -> tuple[int, bool, float, FloatArray | None]:
        """Return how many placements of a way can be reached, the first anyhow and the others straight, whether the first is
        free of what is seen, the joint motion [rad], and the configuration at the first (n,).
        """
        try:
            start, is_free = self._driver.reach(self.joints, way[0], self._rng)
        except PlanningError:
            return 0, False, 0.0, None
        q, legs, motion = start, 1, float(np.abs(start - self.joints).sum())
        for target in way[1:]:
            try:
                path = straight_path(self._arm, q, se3_to_pose(target))
            except PlanningError:
                break
            motion += float(np.abs(np.diff(path, axis=0)).sum())
            q, legs = np.clip(path[-1], self._arm.limits.lower, self._arm.limits.upper), legs + 1
        return legs, is_free, motion, start

    @property
    def _fingers(self) -> FloatArray:
        return np.asarray(self.seen.gripper_joint_positions, dtype=float)


def line(start: pin.SE3, end: pin.SE3, step: float, turn: float) -> list[pin.SE3]:
    """Return placements after `start` up to `end`, at most `step` [m] and `turn` [rad] from each other."""
    shift, rotation = end.translation - start.translation, pin.log3(start.rotation.T @ end.rotation)
    count = max(1, int(np.ceil(max(np.linalg.norm(shift) / step, np.linalg.norm(rotation) / turn))))
    shares = [k / count for k in range(1, count + 1)]
    return [pin.SE3(start.rotation @ pin.exp3(u * rotation), start.translation + u * shift) for u in shares]


def apart(a: pin.SE3, b: pin.SE3) -> float:
    """Return how far two placements are apart, an angle of 1 rad as 0.1 m [m]."""
    turn = float(np.linalg.norm(pin.log3(a.rotation.T @ b.rotation)))
    return float(np.linalg.norm(a.translation - b.translation)) + 0.1 * turn
