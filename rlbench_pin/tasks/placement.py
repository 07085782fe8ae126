"""Random placement of the whole task on the table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rlbench_pin.errors import BoundaryError, InvalidValue
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray, pose_to_se3, relative
from rlbench_pin.tasks.boxes import OrientedBox, rotated
from rlbench_pin.tasks.conditions.parts import as_part
from rlbench_pin.tasks.spawn_boundary import ANY_YAW
from rlbench_pin.tasks.things import THING, WORLD, Rooted, Rotation, Thing, as_rotations
from rlbench_pin.values import as_record, items_of

if TYPE_CHECKING:
    from rlbench_pin.sim import Body, World

MAX_TURNS = 100
"""Orientations of the task that are tried."""


@dataclass(frozen=True)
class PlacementArea:
    """The part of the table top on which tasks are placed, in the world frame [m]."""

    x: tuple[float, float] = (-0.074, 0.574)
    y: tuple[float, float] = (-0.455, 0.455)
    z: float = TABLE_HEIGHT

    @property
    def low(self) -> FloatArray:
        """Lowest x and y, shape (2,)."""
        return np.array([self.x[0], self.y[0]])

    @property
    def high(self) -> FloatArray:
        """Highest x and y, shape (2,)."""
        return np.array([self.x[1], self.y[1]])


PLACEMENT_AREA = PlacementArea()


def place_task(world: World, rng: np.random.Generator, bounds: tuple[Rotation, Rotation] = ANY_YAW) -> None:
    """Place the task root at random in the placement area; only its footprint has to fit.

    Args:
        world: The world whose root is moved, with all its descendants.
        rng: Random generator.
        bounds: Lowest and highest roll, pitch, yaw on top of the nominal orientation [rad].

    Raises:
        BoundaryError: The footprint does not fit at any of `MAX_TURNS` drawn orientations.
        InvalidValue: Something is no world, generator or pair of rotations.
    """
    as_part(world, Rooted, "world", WORLD)
    as_record(rng, np.random.Generator, "rng")
    if len(items_of(bounds)) != 2:
        raise InvalidValue("bounds", bounds, "has to be the lowest and the highest roll, pitch, yaw", "They are in radians.")
    rotations = as_rotations(*bounds, "bounds[0]", "bounds[1]")
    nominal = np.array(world.spec.placement.pose)
    low, high = footprint(world)
    for _ in range(MAX_TURNS):
        quaternion = rotated(rng.uniform(*rotations), nominal[3:])
        corners = np.array([[x, y, 0.0] for x in (low[0], high[0]) for y in (low[1], high[1])])
        patch = corners @ pose_to_se3(np.concatenate([np.zeros(3), quaternion])).rotation.T
        first = PLACEMENT_AREA.low - patch[:, :2].min(axis=0)
        last = PLACEMENT_AREA.high - patch[:, :2].max(axis=0)
        if np.all(first <= last):
            world.place_root(np.concatenate([rng.uniform(first, last), nominal[2:3], quaternion]))
            return
    size, area = np.round(high - low, 3).tolist(), np.round(PLACEMENT_AREA.high - PLACEMENT_AREA.low, 3).tolist()
    raise BoundaryError(
        f"The footprint {size} m of the task does not fit in the placement area {area} m "
        "at any orientation tried. Give [placement] a smaller footprint."
    )


def swap_places(first: Body, second: Body) -> None:
    """Exchange x and y of two bodies; heights and orientations stay."""
    as_part(first, Thing, "first", THING)
    as_part(second, Thing, "second", THING)
    pose, other = np.array(first.pose), np.array(second.pose)
    pose[:2], other[:2] = other[:2].copy(), pose[:2].copy()
    first.set_pose(pose)
    second.set_pose(other)


def footprint(world: World) -> tuple[FloatArray, FloatArray]:
    """Return the lowest and highest x, y of the patch that has to fit, in the root frame, each of shape (2,) [m]."""
    placement = world.spec.placement
    if placement.footprint is not None:
        half, center = np.array(placement.footprint) / 2.0, np.array(placement.footprint_center)
        return center - half, center + half
    root = np.array(world.root.pose)
    corners = [OrientedBox.of(body.bounds(), relative(body.pose, root)).corners() for body in world.bodies.values()]
    if not corners:
        return np.zeros(2), np.zeros(2)
    points = np.concatenate(corners)[:, :2]
    return points.min(axis=0), points.max(axis=0)
