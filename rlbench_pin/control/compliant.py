"""Compliant approach: follow a trajectory into an opening whose position is not exactly known.

The tip follows the trajectory at a bounded speed. The force on the tip follows from the joint torques without gravity: it solves
J^T w = g(q) - tau in the least-squares sense. The force at the first command is taken as the weight of the held object.

* Along the motion, time advances at the rate 1 - f / f_max, where f is the force against the motion: at f_max the arm stops,
  above it the arm moves back.
* Across the motion, the tip yields in proportion to the force (admittance control), so that it centres itself between walls.
* If the force stays near its bound, the tip searches for the opening on an Archimedean spiral r = pitch * angle / (2 pi) across
  the motion (Chhatpar and Branicky 2001). When the path is free, the tip keeps its displacement.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rlbench_pin.control.checks import as_vector, check_made_of
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.robot.trajectory import Trajectory
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_number, as_record


@dataclass(frozen=True)
class CompliantConfig:
    """Bounds and search of a compliant approach."""

    force: float = 20.0
    """Force against the motion at which the arm stops [N]."""
    speed: float = 0.1
    """Largest speed of the tip [m/s]."""
    contact_speed: float = 0.02
    """Largest speed of the tip in contact [m/s]."""
    mobility: float = 5e-5
    """Displacement of the tip across the motion per force, in one tick [m/N]."""
    free_force: float = 3.0
    """Largest force that is not treated as contact [N]."""
    blocked: float = 0.6
    """Fraction of `force` above which the tip searches."""
    pitch: float = 1e-3
    """Distance between two turns of the spiral [m]."""
    step: float = 5e-4
    """Arc length of the spiral per tick [m]."""
    radius: float = 3e-3
    """Radius at which the spiral restarts from its centre [m]."""
    patience: float = 6.0
    """Maximum duration of the approach, in addition to its duration without contact [s]."""

    def __post_init__(self) -> None:
        """Raise InvalidValue for a setting that is not a positive number."""
        for name in self.__dataclass_fields__:
            as_number(getattr(self, name), f"CompliantConfig.{name}", above=0.0)


class CompliantFollowing:
    """Follows one trajectory of a nearly straight tip motion; call `command` once per tick."""

    def __init__(
        self, model: RobotModel, trajectory: Trajectory, dt: float = 0.05, config: CompliantConfig | None = None
    ) -> None:
        """Start at the beginning of the trajectory, with one command per `dt` [s]."""
        check_made_of(model)
        self.model, self.trajectory = model, as_record(trajectory, Trajectory, "trajectory")
        self.dt = as_number(dt, "the control tick dt [s]", least=1e-6)
        self.config = CompliantConfig() if config is None else as_record(config, CompliantConfig, "config")
        begin, end = (model.tip_se3(q).translation for q in (trajectory.q[0], trajectory.q[-1]))
        length = float(np.linalg.norm(end - begin))
        self._direction = (end - begin) / max(length, 1e-9)
        self._across = np.linalg.svd(self._direction[None])[2][1:]
        self._time, self._ticks = 0.0, 0
        self._most_ticks = int((max(trajectory.duration, length / self.config.speed) + self.config.patience) / self.dt)
        self._weight: FloatArray | None = None
        self._yielded, self._angle = np.zeros(3), 0.0

    @property
    def done(self) -> bool:
        """Whether the end of the trajectory was commanded, or `patience` has elapsed."""
        return self._time >= self.trajectory.duration or self._ticks >= self._most_ticks

    @property
    def displacement(self) -> FloatArray:
        """Displacement of the tip from the trajectory (3,), in the world [m]."""
        spiral = self._radius * np.array([np.cos(self._angle), np.sin(self._angle)]) @ self._across
        return np.array(self._yielded + spiral)

    @property
    def _radius(self) -> float:
        """Distance from the centre of the spiral [m]."""
        return self.config.pitch * self._angle / (2.0 * np.pi)

    def command(self, q: ArrayLike, torques: ArrayLike) -> FloatArray:
        """Return the joint positions (n,), [rad], of the next tick.

        Args:
            q: Measured configuration (n,), [rad].
            torques: Joint torques in the last tick (n,), [N m].

        Raises:
            InvalidTarget: NaN or a wrong shape.
        """
        q, torques = (as_vector(x, self.model.size, what) for x, what in ((q, "configuration"), (torques, "torques")))
        self._ticks += 1
        force = self._force(q, torques)
        against = -float(force @ self._direction)
        self._give_way(force + against * self._direction, against)
        self._advance(against)
        target = self.trajectory.sample(self._time)[0]
        jacobian = self.model.jacobian(target)
        target = target + np.linalg.pinv(jacobian, rcond=1e-3) @ np.append(self.displacement, np.zeros(3))
        limits = self.model.limits
        step = limits.velocity * self.dt
        return np.clip(np.clip(target, q - step, q + step), limits.lower, limits.upper)

    def _force(self, q: FloatArray, torques: FloatArray) -> FloatArray:
        """Return the force (3,) of the world on the tip, in the world [N]."""
        wrench = np.linalg.lstsq(self.model.jacobian(q).T, self.model.gravity(q) - torques, rcond=1e-3)[0]
        force: FloatArray = np.asarray(wrench[:3], dtype=float)
        if self._weight is None:
            self._weight = force
        return force - self._weight

    def _give_way(self, across: FloatArray, against: float) -> None:
        """Move across the motion: yield to the force (3,) [N], and follow the spiral if the path is blocked."""
        config = self.config
        size = float(np.linalg.norm(across))
        if size > config.free_force:
            self._yielded += config.mobility * (size - config.free_force) / size * across
        if against > config.blocked * config.force:
            self._angle += config.step / max(self._radius, config.step)
            if self._radius > config.radius:
                self._angle = 0.0

    def _advance(self, against: float) -> None:
        """Advance along the trajectory against a force [N]."""
        config = self.config
        q, v, _ = self.trajectory.sample(self._time)
        speed = float(np.linalg.norm(self.model.jacobian(q)[:3] @ v))
        bound = config.speed if against < config.free_force else min(config.speed, config.contact_speed)
        rate = min(1.0, bound / speed) if speed > 0.0 else 1.0
        rate *= float(np.clip(1.0 - max(against, 0.0) / config.force, -1.0, 1.0))
        self._time = max(0.0, self._time + rate * self.dt)
