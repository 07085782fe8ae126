"""Random places for bodies and frames inside regions, without letting them touch."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from rlbench_pin.errors import BoundaryError, TaskError
from rlbench_pin.spatial import FloatArray, compose, relative
from rlbench_pin.tasks.boxes import OrientedBox, rotated
from rlbench_pin.tasks.conditions.parts import as_part
from rlbench_pin.tasks.things import REGION, THING, Area, Rotation, Solid, Thing, as_rotations, as_things
from rlbench_pin.values import as_flag, as_function, as_number, as_record

if TYPE_CHECKING:
    from rlbench_pin.sim import Body, Frame, Region

MAX_SAMPLES, MAX_LAYOUTS = 100, 200
"""Places that are tried for one thing, and layouts of several things."""
NO_ROTATION: Rotation = (0.0, 0.0, 0.0)
ANY_YAW: tuple[Rotation, Rotation] = ((0.0, 0.0, -3.14), (0.0, 0.0, 3.14))


class SpawnBoundary:
    """Places things inside one or several regions without letting them touch.

    Args:
        regions: Rectangles (height 0) or boxes.

    Raises:
        InvalidValue: Something is no region.
        TaskError: There is none.
    """

    def __init__(self, regions: Iterable[Region]) -> None:
        self._regions = as_things(regions, Area, "regions", REGION)
        if not self._regions:
            raise TaskError(f"SpawnBoundary needs at least one region, {REGION.removeprefix('a region, ')}.")
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

        A region is drawn by its area (or volume), then a rotation on top of the present one, then a place at which the turned
        bounding box fits. A rectangle leaves the height as it is.

        Args:
            thing: What to place.
            rng: Random generator.
            min_rotation: Lowest roll, pitch, yaw in the axes of the region [rad].
            max_rotation: Highest roll, pitch, yaw [rad].
            min_distance: Least distance between origins of things placed by this boundary [m].
            ignore_collisions: Do not look at what this boundary has placed already.

        Raises:
            BoundaryError: No place was found in `MAX_SAMPLES` tries.
            InvalidValue: Something is no body, generator, rotation or distance.
        """
        as_part(thing, Thing, "thing", THING)
        as_record(rng, np.random.Generator, "rng")
        rotations = as_rotations(min_rotation, max_rotation, "min_rotation", "max_rotation")
        min_distance = as_number(min_distance, "min_distance", least=0.0)
        self._place(thing, rng, rotations, min_distance, as_flag(ignore_collisions, "ignore_collisions"))

    def _place(
        self,
        thing: Body | Frame,
        rng: np.random.Generator,
        rotations: tuple[FloatArray, FloatArray],
        min_distance: float,
        ignore_collisions: bool = False,
    ) -> None:
        """Do what `sample` does, when all has been checked."""
        too_big = 0
        start, bounds = np.array(thing.pose), _bounds(thing)
        for _ in range(MAX_SAMPLES):
            region = self._regions[int(rng.choice(len(self._regions), p=self._weights))]
            pose = _draw_pose(region, bounds, start, rng.uniform(*rotations), rng)
            if pose is None:
                too_big += 1
                continue
            box = OrientedBox.of(bounds, pose)
            if ignore_collisions or self._is_free(box, pose[:3], min_distance):
                thing.set_pose(pose)
                self._placed.append((thing.name, box, pose[:3]))
                return
        raise BoundaryError(self._failure(thing, too_big, min_distance))

    def scatter(
        self,
        things: Sequence[Body | Frame],
        rng: np.random.Generator,
        *,
        min_distance: float = 0.01,
        accept: Callable[[], bool] | None = None,
    ) -> None:
        """Forget what was placed and place things one after another, anew until the layout is accepted.

        Args:
            things: What to place, each turned by any yaw.
            rng: Random generator.
            min_distance: Least distance between their origins [m].
            accept: Asked after each layout whether it will do; None takes the first.

        Raises:
            BoundaryError: A thing found no place, or none of `MAX_LAYOUTS` layouts was accepted.
            InvalidValue: Something is no body, generator, distance or function.
        """
        things = as_things(things, Thing, "things", THING)
        as_record(rng, np.random.Generator, "rng")
        as_function(accept, "accept")
        min_distance = as_number(min_distance, "min_distance", least=0.0)
        rotations = as_rotations(*ANY_YAW, "min_rotation", "max_rotation")
        for _ in range(MAX_LAYOUTS):
            self.clear()
            for thing in things:
                self._place(thing, rng, rotations, min_distance)
            if accept is None or accept():
                return
        names = ", ".join(thing.name for thing in things)
        raise BoundaryError(f"None of {MAX_LAYOUTS} layouts of {names} was accepted. Enlarge the regions or ask for less space.")

    def _is_free(self, box: OrientedBox, origin: FloatArray, min_distance: float) -> bool:
        return not any(_are_near(origin, place, min_distance) or box.overlaps(other) for _, other, place in self._placed)

    def _failure(self, thing: Body | Frame, too_big: int, min_distance: float) -> str:
        names = ", ".join(region.name for region in self._regions)
        placed = ", ".join(name for name, _, _ in self._placed) or "nothing"
        size = np.round(np.ptp(_bounds(thing), axis=0), 3).tolist()
        return (
            f"'{thing.name}' of size {size} m found no place in {MAX_SAMPLES} tries in {names}: {too_big} times it did not fit, "
            f"{MAX_SAMPLES - too_big} times it was within {min_distance} m of or touched what is there ({placed}). "
            "Enlarge the regions or lower min_distance."
        )


def clearance(thing: Body | Frame, others: Iterable[Body | Frame]) -> float:
    """Return the least horizontal distance between the origin of a thing and those of others [m]; itself does not count.

    Infinity where there are no others.
    """
    as_part(thing, Thing, "thing", THING)
    others = as_things(others, Thing, "others", THING)
    gaps = (np.linalg.norm((other.position - thing.position)[:2]) for other in others if other is not thing)
    return float(min(gaps, default=np.inf))


def _are_near(a: FloatArray, b: FloatArray, distance: float) -> bool:
    way = a - b
    return bool(way @ way < distance * distance)


def _measure(region: Region) -> float:
    size = np.asarray(region.size, dtype=float)
    return float(np.prod(size if size[2] > 0.0 else size[:2]))


def _bounds(thing: Body | Frame) -> FloatArray:
    """Local bounding box (2, 3) [m]; a frame is a point."""
    return np.asarray(thing.bounds(), dtype=float) if isinstance(thing, Solid) else np.zeros((2, 3))


def _draw_pose(
    region: Region, bounds: FloatArray, start: FloatArray, rotation: FloatArray, rng: np.random.Generator
) -> FloatArray | None:
    """Draw a world pose at which the turned bounding box lies in the region; None when it cannot."""
    frame = np.array(region.pose)
    local = relative(start, frame)
    local[3:] = rotated(rotation, local[3:])
    corners = OrientedBox.of(bounds, np.concatenate([np.zeros(3), local[3:]])).corners()
    half = np.asarray(region.size, dtype=float) / 2.0
    first, last = -half - corners.min(axis=0), half - corners.max(axis=0)
    axes = 3 if half[2] > 0.0 else 2
    if np.any(first[:axes] > last[:axes]):
        return None
    local[:axes] = rng.uniform(first[:axes], last[:axes])
    return compose(frame, local)
