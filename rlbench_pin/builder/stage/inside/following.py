"""The arm follows a hand that is dragged: differential inverse kinematics, some ticks at a time."""

from __future__ import annotations

import numpy as np

from rlbench_pin.control.differential_ik import DifferentialIK
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray, relative
from rlbench_pin.values import as_vector

TICKS = 30
"""Control ticks of one step at most."""
_THERE = 1e-4
"""A tip that is nearer than this has arrived, [m] and [rad]."""


class Follower:
    """Moves a configuration towards a pose of the tip, within the joint limits.

    Args:
        model: The arm.
    """

    def __init__(self, model: RobotModel) -> None:
        self.model, self._controller = model, DifferentialIK(model)

    def follow(self, pose: FloatArray, q: FloatArray) -> tuple[FloatArray, float]:
        """Return the configuration (n,) nearer to a pose (7,), and what is left: the larger of distance [m] and angle [rad]."""
        limits, dt = self.model.limits, self._controller.config.dt
        start = as_vector(q, self.model.size, "configuration")
        q, v = np.clip(start, limits.lower, limits.upper), np.zeros(self.model.size)
        for _ in range(TICKS):
            if self._left(pose, q) < _THERE:
                break
            v = self._controller.velocity_to_pose(q, v, pose)
            q = np.clip(q + dt * v, limits.lower, limits.upper)
        return q, self._left(pose, q)

    def _left(self, pose: FloatArray, q: FloatArray) -> float:
        off = relative(pose, self.model.tip_pose(q))
        angle = 2.0 * np.arctan2(np.linalg.norm(off[3:6]), abs(off[6]))
        return float(max(np.linalg.norm(off[:3]), angle))
