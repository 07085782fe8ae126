"""The hand between looking and moving: it checks what it can reach before it goes."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from rlbench_pin.errors import PlanningError
from rlbench_pin.evaluation.baselines.classical.perception import View, look
from rlbench_pin.observation import Observation
from rlbench_pin.planning import solve_ik, straight_path
from rlbench_pin.robot import RobotModel
from rlbench_pin.spatial import FloatArray, se3_to_pose


@dataclass(frozen=True, eq=False)
class Move:
    """One action: where the tip goes, and what the fingers do then."""

    pose: FloatArray
    """Tip in the world (7,)."""
    is_open: bool
    """Whether the fingers are open at the end."""


Moves = Generator[Move, Observation, None]
"""What a skill is: it yields moves and is sent what is seen after each."""


class Hand:
    """The arm with its hand as a skill sees it: what was observed last, and what it may reach from there."""

    def __init__(self, arm: RobotModel, observation: Observation, rng: np.random.Generator) -> None:
        """Begin with what is seen at the start of an episode."""
        self.arm, self.seen, self._rng = arm, observation, rng
        self.is_open = True

    def look(self) -> View:
        """Return what the last observation shows."""
        return look(self.seen, self.arm)

    @property
    def joints(self) -> FloatArray:
        """Where the joints of the arm are (n,) [rad]."""
        return np.asarray(self.seen.joint_positions, dtype=float)

    @property
    def tip(self) -> pin.SE3:
        """Where the tip is."""
        return self.arm.tip_se3(self.joints)

    def go(self, target: pin.SE3, is_open: bool | None = None) -> Moves:
        """Move the tip to a placement; then open or close the fingers, or leave them when None."""
        self.is_open = self.is_open if is_open is None else is_open
        self.seen = yield Move(se3_to_pose(target), self.is_open)

    def shift(self, by: Iterable[float], is_open: bool | None = None) -> Moves:
        """Move the tip by a vector (3,) of the world [m]."""
        here = self.tip
        yield from self.go(pin.SE3(here.rotation, here.translation + np.array(list(by))), is_open)

    def follow(self, targets: Sequence[pin.SE3], is_open: bool | None = None) -> Moves:
        """Move the tip to several placements, one after the other."""
        for target in targets:
            yield from self.go(target, is_open)

    def grip(self, is_open: bool) -> Moves:
        """Open or close the fingers where the hand is."""
        yield from self.go(self.tip, is_open)

    def choose(self, ways: Sequence[Sequence[pin.SE3]]) -> Sequence[pin.SE3]:
        """Return the way that the arm can follow farthest; of several, the one of least joint motion."""
        scored = [(self._follows(way), -k, way) for k, way in enumerate(ways)]
        return max(scored, key=lambda item: item[:2])[2]

    def _follows(self, way: Sequence[pin.SE3]) -> tuple[int, float]:
        """Return how many legs of a way can be followed, the first anyhow and the others straight, and minus the joint motion."""
        q = np.clip(self.joints, self.arm.limits.lower, self.arm.limits.upper)
        motion, legs = 0.0, 0
        for leg, target in enumerate(way):
            try:
                path = self._leg(q, target, leg == 0)
            except PlanningError:
                break
            motion += float(np.abs(np.diff(path, axis=0)).sum())
            q, legs = np.clip(path[-1], self.arm.limits.lower, self.arm.limits.upper), legs + 1
        return legs, -motion

    def _leg(self, q: FloatArray, target: pin.SE3, anyhow: bool) -> FloatArray:
        """Return configurations (m, n) to a target; raises PlanningError when there are none."""
        pose = se3_to_pose(target)
        try:
            return straight_path(self.arm, q, pose)
        except PlanningError:
            if not anyhow:
                raise
            return np.array([q, solve_ik(self.arm, pose, q, self._rng, starts=10)[0]])
