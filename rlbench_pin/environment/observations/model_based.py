"""Quantities of the analytic model at one instant: Jacobians, dynamics and distances, on request.

Everything is written to `Observation.misc` under the names of the settings:

| key | value |
|---|---|
| `tip_jacobian` | (6, n), `[linear, angular]` of the tip along world axes per joint velocity |
| `tip_jacobian_dot` | its time derivative, (6, n) |
| `mass_matrix` | joint-space inertia, (n, n), [kg m^2] |
| `gravity` | torques that carry the arm's weight, (n,), [N m] |
| `coriolis` | C(q, v) v, (n,), [N m] |
| `manipulability` | sqrt(det(J J^T)) |
| `world_distances`, `self_distances` | the nearest pairs as `Distance` records: names, distance [m], points, normal |
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from rlbench_pin.robot.collision import Distance
from rlbench_pin.robot.distances import DistanceModel
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.sim import World
from rlbench_pin.values import FLAG, check_settings, counted, ruled

_RULES = ruled(
    (FLAG, "tip_jacobian tip_jacobian_dot mass_matrix gravity coriolis manipulability"),
    (counted(0), "world_distances self_distances"),
)


@dataclass(frozen=True, kw_only=True)
class ModelObservationConfig:
    """Which model-based quantities are delivered; none by default."""

    tip_jacobian: bool = False
    tip_jacobian_dot: bool = False
    mass_matrix: bool = False
    gravity: bool = False
    coriolis: bool = False
    manipulability: bool = False
    world_distances: int = 0
    """How many of the nearest pairs of arm and world."""
    self_distances: int = 0
    """How many of the nearest pairs of the arm with itself."""

    def __post_init__(self) -> None:
        """Raise InvalidValue for a switch that is none, or a number of pairs that is no whole number >= 0."""
        check_settings(self, _RULES)

    @property
    def is_used(self) -> bool:
        """Whether anything is wanted."""
        return any(vars(self).values())


class ModelObserver:
    """Computes them for one world; keeps its distance model between observations.

    Args:
        world: Gives joint states and the places of all bodies.
        model: The arm.
    """

    def __init__(self, world: World, model: RobotModel) -> None:
        self._world, self._model = world, model
        self._distances: DistanceModel | None = None

    def observe(self, config: ModelObservationConfig) -> dict[str, Any]:
        """Return the wanted quantities by name."""
        q, v = self._world.robot.joint_positions, self._world.robot.joint_velocities
        model = self._model
        ways = {
            "tip_jacobian": lambda: model.jacobian(q).copy(),
            "tip_jacobian_dot": lambda: model.jacobian_dot(q, v),
            "mass_matrix": lambda: model.mass_matrix(q),
            "gravity": lambda: model.gravity(q),
            "coriolis": lambda: model.coriolis(q, v),
            "manipulability": lambda: model.manipulability(q),
        }
        found: dict[str, Any] = {name: way() for name, way in ways.items() if getattr(config, name)}
        if config.world_distances or config.self_distances:
            found.update(self._nearest(config))
        return found

    def _nearest(self, config: ModelObservationConfig) -> dict[str, tuple[Distance, ...]]:
        if self._distances is None:
            self._distances = DistanceModel(self._model)
        snapshot = self._world.snapshot()
        self._distances.update(snapshot)
        bodies = {body.name for body in snapshot.bodies} - set(snapshot.attached)
        pairs = self._distances.nearest(snapshot.arm, count=10_000)
        world = [pair for pair in pairs if pair.a in bodies or pair.b.partition("/")[0] in bodies]
        own = [pair for pair in pairs if pair not in world]
        return {
            **({"world_distances": tuple(world[: config.world_distances])} if config.world_distances else {}),
            **({"self_distances": tuple(own[: config.self_distances])} if config.self_distances else {}),
        }
