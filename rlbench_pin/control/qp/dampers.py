"""Velocity dampers: no pair of bodies closes in faster than its distance allows. Equation (1) of `control.safety_filter`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.control.safety_records import SafetyConfig
from rlbench_pin.robot.distances import DistanceModel
from rlbench_pin.robot.motion_bounds import IndexArray
from rlbench_pin.spatial import FloatArray

ROWS = 32
"""Pairs that take part in the QP, those nearest to breaking a damper first."""
SLACK = 1e-5
"""How much nearer than it is a pair below the minimum may come [m]."""


@dataclass(frozen=True, eq=False, slots=True)
class DamperRows:
    """Rows `gradients` u >= `least` of a quadratic program."""

    which: IndexArray
    """Numbers of the pairs, shape (m,)."""
    gradients: FloatArray
    """Of their distances, shape (m, n), [m/rad]."""
    least: FloatArray
    """Least rates of change, shape (m,), [m/s]."""


class Dampers:
    """The dampers of one arm in its world.

    Args:
        distances: Of the arm.
        config: Settings of the filter.
    """

    def __init__(self, distances: DistanceModel, config: SafetyConfig) -> None:
        self.distances, self.config = distances, config
        self._counts: NDArray[np.bool_] | None = None
        self._minimum = self._onset = np.zeros(0)

    def floors(self) -> FloatArray:
        """Return the smallest distance allowed, shape (pairs,), [m]; minus infinity for pairs that do not count."""
        model = self.distances
        if self._counts is not model.counts:
            self._counts = model.counts
            minimum = np.where(model.crosses, self.config.margin, self.config.self_margin)
            self._minimum = np.where(model.counts, minimum, -np.inf)
            self._onset = self._minimum + self.config.buffer
        return self._minimum

    def lowered(self) -> FloatArray:
        """Return the floors, lowered where a pair is below its own already."""
        model, floors = self.distances, self.floors()
        which = (model.bounds < floors).nonzero()[0]  # perhaps, or for sure: bounds are exact where it matters
        if len(which):
            floors = floors.copy()
            floors[which] = np.minimum(floors[which], model.measure(which) - SLACK)
        return floors

    def nothing_near(self, turns: FloatArray) -> bool:
        """Whether all pairs are farther apart than where dampers begin and what joint turns (n,) [rad] can take at most now."""
        model = self.distances
        self.floors()
        limit = model.motion.approach(turns)
        limit += self._onset
        near = (model.bounds < limit).nonzero()[0]  # perhaps
        return all(model.distance(k) >= least for k, least in zip(near.tolist(), limit.take(near).tolist()))

    def rows(self, speeds: FloatArray) -> DamperRows:
        """Return rows for pairs that are near, or might break a damper while joints move at up to `speeds` (n,) [rad/s]."""
        model = self.distances
        self.floors()
        config, onset = self.config, self._onset
        reach = np.maximum(model.motion.approach(speeds / config.gain), config.influence)
        near = (model.bounds - onset < reach).nonzero()[0]
        spare = model.measure(near) - onset[near]
        keep = spare < reach[near]
        near, spare = near[keep], spare[keep]
        if len(near) > ROWS:
            first = np.argsort(spare - np.minimum(reach[near], 1.0 / config.gain), kind="stable")[:ROWS]
            near, spare = near[first], spare[first]
        return DamperRows(near, model.gradients(near), np.minimum(-config.gain * spare, config.recovery_speed))
