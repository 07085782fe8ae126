"""Random placement: of bodies and frames in regions without contact, and of the whole task on the table."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

import numpy as np

from rlbench_pin.errors import BoundaryError, InvalidValue, TaskError
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray, pose_at, pose_to_se3, relative, se3_to_pose
from rlbench_pin.tasks.arguments import MOVABLE, REGION, ROOTED_WORLD, Rotation, as_object, as_objects, as_rotations, has_extent
from rlbench_pin.tasks.boxes import OrientedBox, rotated
from rlbench_pin.values import as_flag, as_function, as_number, as_record, items_of

if TYPE_CHECKING:
    from rlbench_pin.sim import Body, Frame, Region, World


MAX_SAMPLES, MAX_LAYOUTS = 100, 200
"""Maximum number of poses to try for one object, and of layouts of several objects."""
NO_ROTATION: Rotation = (0.0, 0.0, 0.0)
ANY_YAW: tuple[Rotation, Rotation] = ((0.0, 0.0, -3.14), (0.0, 0.0, 3.14))


class SpawnBoundary:
    """Places objects in one or several regions without contact.

    Args:
        regions: Rectangles (height 0) or boxes.

    Raises:
        InvalidValue: An entry is not a region.
        TaskError: `regions` is empty.
    """

    def __init__(self, regions: Iterable[Region]) -> None:
        self._regions = as_objects(regions, REGION, "regions")
        if not self._regions:
            raise TaskError(f"SpawnBoundary needs at least one region, {REGION.words.removeprefix('a region, ')}.")
        measures = np.array([_measure(region) for region in self._regions])
        self._weights = measures / measures.sum()
        self._placed: list[tuple[str, OrientedBox, FloatArray]] = []

    def clear(self) -> None:
        """Forget the placed objects; call this at the start of each episode."""
        self._placed.clear()

    def state(self) -> tuple[tuple[str, OrientedBox, FloatArray], ...]:
        """Return the objects placed since the last `clear`."""
        return tuple(self._placed)

    def set_state(self, state: tuple[tuple[str, OrientedBox, FloatArray], ...]) -> None:
        """Restore the placed objects that `state()` returned."""
        self._placed[:] = state

    def sample(
        self,
        element: Body | Frame,
        rng: np.random.Generator,
        *,
        min_rotation: Rotation = ANY_YAW[0],
        max_rotation: Rotation = ANY_YAW[1],
        min_distance: float = 0.01,
        apart: Mapping[str, float] | None = None,
        ignore_collisions: bool = False,
    ) -> None:
        """Move a body or a frame to a random pose.

        A region is drawn by its area (or volume), then a rotation relative to the present one, then a position at which the
        rotated bounding box fits. A rectangle does not change the height.

        Args:
            element: Body or frame to place.
            rng: Random generator.
            min_rotation: Lowest roll, pitch, yaw in the axes of the region [rad].
            max_rotation: Highest roll, pitch, yaw [rad].
            min_distance: Minimum distance between origins of objects placed by this boundary [m].
            apart: Larger minimum distances from some of them, by name [m].
            ignore_collisions: Ignore the objects that this boundary has placed.

        Raises:
            BoundaryError: No pose was found in `MAX_SAMPLES` attempts.
            InvalidValue: An argument is not a body, generator, rotation or distance.
        """
        as_object(element, MOVABLE, "element")
        as_record(rng, np.random.Generator, "rng")
        rotations = as_rotations(min_rotation, max_rotation, "min_rotation", "max_rotation")
        min_distance = as_number(min_distance, "min_distance", least=0.0)
        apart = as_record({} if apart is None else apart, Mapping, "apart")  # type: ignore[type-abstract]
        gaps = {name: as_number(gap, f"apart[{name!r}]", least=0.0) for name, gap in apart.items()}
        self._place(element, rng, rotations, min_distance, gaps, as_flag(ignore_collisions, "ignore_collisions"))

    def _place(
        self,
        element: Body | Frame,
        rng: np.random.Generator,
        rotations: tuple[FloatArray, FloatArray],
        min_distance: float,
        apart: Mapping[str, float],
        ignore_collisions: bool = False,
    ) -> None:
        """Place an object as `sample` does, without checks of the arguments."""
        start, bounds, too_big = np.array(element.pose), _bounds(element), 0
        for _ in range(MAX_SAMPLES):
            pose = _draw_pose(self._draw_region(rng), bounds, start, rng.uniform(*rotations), rng)
            if pose is None:
                too_big += 1
                continue
            box = OrientedBox.of(bounds, pose)
            if ignore_collisions or self._is_free(box, pose[:3], min_distance, apart):
                element.set_pose(pose)
                self._placed.append((element.name, box, pose[:3]))
                return
        raise BoundaryError(self._failure(element, too_big, min_distance))

    def scatter(
        self,
        elements: Sequence[Body | Frame],
        rng: np.random.Generator,
        *,
        min_distance: float = 0.01,
        accept: Callable[[], bool] | None = None,
    ) -> None:
        """Forget the placed objects, and place objects in order; repeat until the layout is accepted.

        Args:
            elements: Bodies and frames to place, each at any yaw.
            rng: Random generator.
            min_distance: Minimum distance between their origins [m].
            accept: Function that is called after each layout and returns whether to accept it; None accepts the first.

        Raises:
            BoundaryError: An object has no valid pose, or none of `MAX_LAYOUTS` layouts was accepted.
            InvalidValue: An argument is not a body, generator, distance or function.
        """
        elements = as_objects(elements, MOVABLE, "elements")
        as_record(rng, np.random.Generator, "rng")
        as_function(accept, "accept")
        min_distance = as_number(min_distance, "min_distance", least=0.0)
        rotations = as_rotations(*ANY_YAW, "min_rotation", "max_rotation")
        for _ in range(MAX_LAYOUTS):
            self.clear()
            for element in elements:
                self._place(element, rng, rotations, min_distance, {})
            if accept is None or accept():
                return
        names = ", ".join(element.name for element in elements)
        raise BoundaryError(
            f"None of {MAX_LAYOUTS} layouts of {names} was accepted. Enlarge the regions, or place fewer objects."
        )

    def _draw_region(self, rng: np.random.Generator) -> Region:
        return self._regions[int(rng.choice(len(self._regions), p=self._weights)) if len(self._regions) > 1 else 0]

    def _is_free(self, box: OrientedBox, origin: FloatArray, least: float, apart: Mapping[str, float]) -> bool:
        return not any(
            _are_near(origin, place, max(least, apart.get(name, 0.0))) or box.overlaps(other)
            for name, other, place in self._placed
        )

    def _failure(self, element: Body | Frame, too_big: int, min_distance: float) -> str:
        names = ", ".join(region.name for region in self._regions)
        placed = ", ".join(name for name, _, _ in self._placed) or "nothing"
        size = np.round(np.ptp(_bounds(element), axis=0), 3).tolist()
        return (
            f"'{element.name}' of size {size} m found no place in {MAX_SAMPLES} tries in {names}: {too_big} times it did not fit,"
            f" {MAX_SAMPLES - too_big} times it was within {min_distance} m of or touched what is there ({placed}). "
            "Enlarge the regions or lower min_distance."
        )


def clearance(element: Body | Frame, others: Iterable[Body | Frame]) -> float:
    """Return the smallest horizontal distance between the origin of an object and those of other objects [m].

    The object itself is ignored. Infinity without other objects.
    """
    as_object(element, MOVABLE, "element")
    others = as_objects(others, MOVABLE, "others")
    gaps = (np.linalg.norm((other.position - element.position)[:2]) for other in others if other is not element)
    return float(min(gaps, default=np.inf))


def _are_near(a: FloatArray, b: FloatArray, distance: float) -> bool:
    return distance > 0.0 and math.dist(a, b) < distance


def _measure(region: Region) -> float:
    size = np.asarray(region.size, dtype=float)
    return float(np.prod(size if size[2] > 0.0 else size[:2]))


def _bounds(element: Body | Frame) -> FloatArray:
    """Return the local bounding box (2, 3) [m]; a frame is a point."""
    if not has_extent(element):
        return np.zeros((2, 3))
    return np.asarray(cast("Body", element).bounds(), dtype=float)


def _draw_pose(
    region: Region, bounds: FloatArray, start: FloatArray, rotation: FloatArray, rng: np.random.Generator
) -> FloatArray | None:
    """Draw a world pose at which the rotated bounding box is in the region; None if it does not fit."""
    T_world_region = pose_to_se3(region.pose)
    T_region_object = T_world_region.actInv(pose_to_se3(start))
    place = np.array(T_region_object.translation)
    T_region_object = pose_to_se3(pose_at((0.0, 0.0, 0.0), *rotation)) * T_region_object
    low, high = bounds
    turn = T_region_object.rotation
    middle, reach = turn @ (0.5 * (low + high)), np.abs(turn) @ (0.5 * (high - low))
    half = np.asarray(region.size, dtype=float) / 2.0
    first, last = reach - half - middle, half - reach - middle
    axes = 3 if half[2] > 0.0 else 2
    if (first[:axes] > last[:axes]).any():
        return None
    place[:axes] = rng.uniform(first[:axes], last[:axes])
    T_region_object.translation = place
    return se3_to_pose(T_world_region * T_region_object)


MAX_TURNS = 100
"""Maximum number of orientations of the task to try."""


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
    """Move the task root to a random pose in the placement area; only its footprint has to fit.

    Args:
        world: The world whose task root is moved, with all descendants.
        rng: Random generator.
        bounds: Lowest and highest roll, pitch, yaw relative to the nominal orientation [rad].

    Raises:
        BoundaryError: The footprint does not fit at any of `MAX_TURNS` drawn orientations.
        InvalidValue: An argument is not a world, generator or pair of rotations.
    """
    as_object(world, ROOTED_WORLD, "world")
    as_record(rng, np.random.Generator, "rng")
    if len(items_of(bounds)) != 2:
        raise InvalidValue("bounds", bounds, "has to be the lowest and the highest roll, pitch, yaw", "Pass radians.")
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
    """Exchange x and y of two bodies; heights and orientations do not change."""
    as_object(first, MOVABLE, "first")
    as_object(second, MOVABLE, "second")
    pose, other = np.array(first.pose), np.array(second.pose)
    pose[:2], other[:2] = other[:2].copy(), pose[:2].copy()
    first.set_pose(pose)
    second.set_pose(other)


def footprint(world: World) -> tuple[FloatArray, FloatArray]:
    """Return the lowest and highest x, y of the footprint in the root frame, each of shape (2,) [m]."""
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
