"""Random placement: objects inside regions, and the whole task on the table."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rlbench_pin.errors import BoundaryError, TaskError
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray, compose, pose_at, pose_to_se3, relative
from rlbench_pin.tasks.boxes import OrientedBox

if TYPE_CHECKING:
    from rlbench_pin.sim import Body, Frame, Region, World

Rotation = tuple[float, float, float]
MAX_SAMPLES = 100
NO_ROTATION: Rotation = (0.0, 0.0, 0.0)
ANY_YAW: tuple[Rotation, Rotation] = ((0.0, 0.0, -3.14), (0.0, 0.0, 3.14))


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


class SpawnBoundary:
    """Places things inside one or several regions without letting them touch.

    Args:
        regions: Rectangles (height 0) or boxes.
    """

    def __init__(self, regions: Iterable[Region]) -> None:
        self._regions = tuple(regions)
        if not self._regions:
            raise TaskError("SpawnBoundary needs at least one region.")
        measures = np.array([_measure(region) for region in self._regions])
        self._weights = measures / measures.sum()
        self._placed: list[tuple[str, OrientedBox, FloatArray]] = []

    def clear(self) -> None:
        """Forget what was placed; call it at the start of every episode."""
        self._placed.clear()

    def state(self) -> tuple[tuple[str, OrientedBox, FloatArray], ...]:
        """Return what was placed since the last `clear`."""
        return tuple(self._placed)

    def set_state(self, state: tuple[tuple[str, OrientedBox, FloatArray], ...]) -> None:
        """Remember as placed what `state()` returned before."""
        self._placed[:] = state

    def sample(
        self,
        thing: Body | Frame,
        rng: np.random.Generator,
        *,
        min_rotation: Rotation = ANY_YAW[0],
        max_rotation: Rotation = ANY_YAW[1],
        min_distance: float = 0.01,
        ignore_collisions: bool = False,
    ) -> None:
        """Move a body or a frame to a random place.

        A region is drawn in proportion to its area (or volume), then a rotation between the bounds, on top of the present
        orientation, then a place at which the turned bounding box fits. A rectangle leaves the height as it is.

        Args:
            thing: What to place.
            rng: Source of chance.
            min_rotation: Lowest roll, pitch, yaw in the axes of the region [rad].
            max_rotation: Highest roll, pitch, yaw [rad].
            min_distance: Least distance between origins of things placed by this boundary [m].
            ignore_collisions: Do not look at what this boundary has placed already.

        Raises:
            BoundaryError: No place was found in `MAX_SAMPLES` tries.
        """
        too_big = 0
        start = np.array(thing.pose)
        for _ in range(MAX_SAMPLES):
            region = self._regions[int(rng.choice(len(self._regions), p=self._weights))]
            rotation = rng.uniform(min_rotation, max_rotation)
            pose = _draw_pose(region, thing, start, rotation, rng)
            if pose is None:
                too_big += 1
                continue
            box = OrientedBox.of(_bounds(thing), pose)
            if ignore_collisions or self._is_free(box, pose[:3], min_distance):
                thing.set_pose(pose)
                self._placed.append((thing.name, box, pose[:3]))
                return
        raise BoundaryError(self._failure(thing, too_big, min_distance))

    def _is_free(self, box: OrientedBox, origin: FloatArray, min_distance: float) -> bool:
        return not any(np.linalg.norm(origin - place) < min_distance or box.overlaps(other) for _, other, place in self._placed)

    def _failure(self, thing: Body | Frame, too_big: int, min_distance: float) -> str:
        names = ", ".join(region.name for region in self._regions)
        placed = ", ".join(name for name, _, _ in self._placed) or "nothing"
        size = np.round(np.ptp(_bounds(thing), axis=0), 3).tolist()
        return (
            f"'{thing.name}' of size {size} m found no place in {MAX_SAMPLES} tries in {names}: {too_big} times it did not fit, "
            f"{MAX_SAMPLES - too_big} times it was within {min_distance} m of or touched what is there ({placed}). "
            "Enlarge the regions or lower min_distance."
        )


def place_task(world: World, rng: np.random.Generator, bounds: tuple[Rotation, Rotation] = ANY_YAW) -> None:
    """Place the task root at random in the placement area; only its footprint has to fit.

    Args:
        world: The world whose root is moved, with everything that hangs on it.
        rng: Source of chance.
        bounds: Lowest and highest roll, pitch, yaw on top of the nominal orientation [rad].

    Raises:
        BoundaryError: The footprint does not fit at any of `MAX_SAMPLES` drawn orientations.
    """
    nominal = np.array(world.spec.placement.pose)
    low, high = footprint(world)
    for _ in range(MAX_SAMPLES):
        quaternion = _turned(rng.uniform(*bounds), nominal[3:])
        corners = np.array([[x, y, 0.0] for x in (low[0], high[0]) for y in (low[1], high[1])])
        turned = corners @ pose_to_se3(np.concatenate([np.zeros(3), quaternion])).rotation.T
        first = PLACEMENT_AREA.low - turned[:, :2].min(axis=0)
        last = PLACEMENT_AREA.high - turned[:, :2].max(axis=0)
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


def _measure(region: Region) -> float:
    size = np.asarray(region.size, dtype=float)
    return float(np.prod(size if size[2] > 0.0 else size[:2]))


def _bounds(thing: Body | Frame) -> FloatArray:
    """Local bounding box (2, 3) [m]; a frame is a point."""
    return np.asarray(thing.bounds(), dtype=float) if hasattr(thing, "bounds") else np.zeros((2, 3))


def _turned(rotation: FloatArray, quaternion: FloatArray) -> FloatArray:
    """Apply roll, pitch, yaw [rad] on top of an orientation, about the axes it is given in."""
    turn = pose_at((0.0, 0.0, 0.0), *rotation)
    return compose(turn, np.concatenate([np.zeros(3), quaternion]))[3:]


def _draw_pose(
    region: Region, thing: Body | Frame, start: FloatArray, rotation: FloatArray, rng: np.random.Generator
) -> FloatArray | None:
    """Draw a world pose at which the turned bounding box lies in the region; None when it cannot."""
    frame = np.array(region.pose)
    local = relative(start, frame)
    local[3:] = _turned(rotation, local[3:])
    corners = OrientedBox.of(_bounds(thing), np.concatenate([np.zeros(3), local[3:]])).corners()
    half = np.asarray(region.size, dtype=float) / 2.0
    first, last = -half - corners.min(axis=0), half - corners.max(axis=0)
    axes = 3 if half[2] > 0.0 else 2
    if np.any(first[:axes] > last[:axes]):
        return None
    local[:axes] = rng.uniform(first[:axes], last[:axes])
    return compose(frame, local)
