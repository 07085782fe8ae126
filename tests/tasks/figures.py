"""The figures of a task that can be measured, by the names that `specification.toml` and `[[deviation]]` give them."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from unittest.mock import patch

import numpy as np

from rlbench_pin.scene import SceneSpec, SensorSpec
from rlbench_pin.sim import Body, World
from rlbench_pin.spatial import euler_to_quaternion
from rlbench_pin.tasks import Condition, JointMoved, SpawnBoundary, Task
from rlbench_pin.tasks.placement import PLACEMENT_AREA, footprint
from rlbench_pin.urdf import read_urdf
from tests.tasks.running import begin, running

Figure = list[float] | str
"""Numbers, or the gripper commands of the waypoints in a row."""
Figures = dict[str, Figure]
YAWS = 4001
"""So many yaws are looked at to see in what share of them a footprint fits."""


def specification() -> dict[str, Figures]:
    """Return task -> figure -> what its specification says; `every` holds unless a task says otherwise."""
    raw = tomllib.loads(Path(__file__).with_name("specification.toml").read_text(encoding="utf-8"))
    every = raw.pop("every")
    return {name: {key: _listed(value) for key, value in (every | own).items()} for name, own in raw.items()}


def measured(name: str) -> Figures:
    """Return all figures of a task as they are: of its scene, and of its class after the start of an episode."""
    with running(name) as task:
        apart = _begin(task)
        world, bounds = task.world, task.base_rotation_bounds()
        bodies = (*world.spec.body, *world.spawned.values())
        figures: dict[str, float | Iterable[float]] = {
            "variations": task.variation_count(),
            "yaw": (bounds[0][2], bounds[1][2]),
            "static": task.is_static_workspace(),
            "yaw that fits": 100.0 if task.is_static_workspace() else 100.0 * _share_that_fits(world),
            "free bodies": sum(not body.fixed for body in bodies),
            "spawned bodies": len(world.spawned),
            "graspable bodies": len(task.get_graspable_objects()),
            "travel": sorted({condition.distance for condition in _conditions(task) if isinstance(condition, JointMoved)}),
            **({"distance apart": max(apart)} if apart else {}),
            **{f"sensor {sensor.name}": _size(sensor) for sensor in world.spec.sensor},
            **{f"region {region.name}": sorted(region.size) for region in world.spec.region},
        }
        for body in bodies:
            figures |= _figures_of(body.name, world.body(body.name))
        return {"gripper": gripper(world.spec), **{key: _listed(value) for key, value in figures.items()}}


def gripper(scene: SceneSpec) -> str:
    """Return what the gripper does after each waypoint: `open`, `close`, a fraction, `-` for nothing."""
    waypoints = sorted(scene.waypoint, key=lambda waypoint: int(waypoint.name.removeprefix("waypoint")))
    return " ".join("-" if waypoint.gripper is None else str(waypoint.gripper) for waypoint in waypoints)


def _begin(task: Task) -> list[float]:
    """Begin an episode, and return the least distances that its draws of places ask for."""
    asked: list[float] = []

    def noting(draw: Callable[..., None]) -> Callable[..., None]:
        def noted(*given: object, min_distance: float = 0.01, **other: object) -> None:
            asked.append(min_distance)
            draw(*given, min_distance=min_distance, **other)

        return noted

    doors = {name: noting(getattr(SpawnBoundary, name)) for name in ("sample", "scatter")}
    with patch.multiple(SpawnBoundary, **doors):
        begin(task)
    return asked


def _conditions(task: Task) -> Iterator[Condition]:
    """Yield the conditions of the success list and those that the task keeps, with what they are made of."""
    waiting: list[object] = [*task.get_success_conditions(), *vars(task).values()]
    while waiting:
        found = waiting.pop()
        if isinstance(found, Condition):
            yield found
            waiting += vars(found).values()
        elif isinstance(found, list | tuple):
            waiting += found


def _figures_of(name: str, body: Body) -> dict[str, Iterable[float] | float]:
    """Return size, height, mass, and the joints of a body."""
    size = _extent(body)
    links = read_urdf(body.model.urdf).links
    figures: dict[str, Iterable[float] | float] = {
        f"size {name}": sorted(size),
        f"height {name}": size[2],
        f"mass {name}": sum(link.inertial.mass for link in links if link.inertial is not None),
        f"joints {name}": len(body.joints),
    }
    for joint in body.joints.values():
        figures[f"range {joint.name}"] = (joint.lower, joint.upper)
        figures[f"joint {joint.name}"] = (joint.lower, joint.upper, joint.position)
    return figures


def _extent(body: Body) -> np.ndarray:
    return np.asarray(body.aabb_size())


def _size(sensor: SensorSpec) -> list[float]:
    return sorted(sensor.size) if sensor.shape == "box" else list(sensor.size)


def _share_that_fits(world: World) -> float:
    """Return the share of the yaws of the scene at which its footprint fits in the placement area."""
    placement, (low, high) = world.spec.placement, footprint(world)
    area, size = PLACEMENT_AREA.high - PLACEMENT_AREA.low, high - low
    assert np.allclose(placement.pose[3:], euler_to_quaternion(0.0, 0.0, 0.0)), "the share is counted from an upright root"
    yaw = np.linspace(*placement.yaw, YAWS)
    along, across = np.abs(np.cos(yaw)), np.abs(np.sin(yaw))
    fits = (size[0] * along + size[1] * across <= area[0]) & (size[0] * across + size[1] * along <= area[1])
    return float(fits.mean())


def _listed(value: object) -> Figure:
    if isinstance(value, str):
        return value
    return [float(v) for v in value] if isinstance(value, Iterable) else [float(value)]  # type: ignore[arg-type]
