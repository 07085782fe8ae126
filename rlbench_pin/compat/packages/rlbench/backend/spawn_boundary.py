"""Random placement inside boundaries, with the API of RLBench. All draws come from numpy's global generator."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from pyrep.objects.object import Object
from pyrep.objects.shape import Shape
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.errors import BoundaryError, TaskError
from rlbench_pin.spatial import FloatArray, pose_at
from rlbench_pin.tasks.boxes import OrientedBox, rotated
from rlbench_pin.tasks.placement import footprint

MAX_SAMPLES = 100
"""Maximum number of tries for one object."""
ANY_YAW = ((0.0, 0.0, -3.14), (0.0, 0.0, 3.14))
"""Default bounds of the random rotation: roll, pitch, yaw [rad]."""
FLAT = 1e-4
"""Height below which a boundary is a plane [m]."""
PLACED, TOO_BIG, TOUCHES, TOO_NEAR = 1, -1, -2, -3
"""Return values of `BoundaryObject.add`."""


class BoundingBox:
    """An axis-aligned box: bounds of x, y and z [m]."""

    def __init__(self, min_x: float, max_x: float, min_y: float, max_y: float, min_z: float, max_z: float) -> None:
        self.min_x, self.max_x, self.min_y, self.max_y, self.min_z, self.max_z = min_x, max_x, min_y, max_y, min_z, max_z

    @property
    def corners(self) -> FloatArray:
        """Corners with the smallest and the largest coordinates, shape (2, 3) [m]."""
        return np.array([[self.min_x, self.min_y, self.min_z], [self.max_x, self.max_y, self.max_z]], dtype=float)

    @classmethod
    def of_corners(cls, corners: FloatArray) -> BoundingBox:
        """Return the box around points (n, 3) [m]."""
        low, high = np.min(corners, axis=0), np.max(corners, axis=0)
        return cls(*(float(bound) for pair in zip(low, high) for bound in pair))

    def within_boundary(self, boundary: BoundingBox, is_plane: bool) -> bool:
        """Return whether this box is inside another; for a plane the height is ignored."""
        axes = 2 if is_plane else 3
        mine, other = self.corners[:, :axes], boundary.corners[:, :axes]
        return bool(np.all(mine[0] >= other[0] - 1e-9) and np.all(mine[1] <= other[1] + 1e-9))

    def rotate(self, rotation: Sequence[float] | FloatArray) -> BoundingBox:
        """Return the axis-aligned box around this box after a rotation about the origin.

        Args:
            rotation: Roll, pitch, yaw (3,) [rad], or a quaternion (4,), x, y, z, w.
        """
        turn = np.asarray(rotation, dtype=float)
        pose = pose_at((0.0, 0.0, 0.0), *turn) if len(turn) == 3 else np.concatenate([np.zeros(3), turn])
        return BoundingBox.of_corners(OrientedBox.of(self.corners, pose).corners())

    def moved(self, position: Sequence[float] | FloatArray) -> BoundingBox:
        """Return the box moved by a vector (3,) [m]."""
        return BoundingBox.of_corners(self.corners + np.asarray(position, dtype=float))


class BoundaryObject:
    """One boundary and the objects in it.

    Args:
        boundary: A plane, on which objects keep their height, or a box.
    """

    def __init__(self, boundary: Object) -> None:
        self._boundary = boundary
        self._boundary_bbox = BoundingBox(*boundary.get_bounding_box())
        self._is_plane = self._boundary_bbox.max_z - self._boundary_bbox.min_z < FLAT
        self._contained_objects: list[Object] = []

    @property
    def contained_objects(self) -> list[Object]:
        """Objects placed in the boundary since the last `clear`."""
        return list(self._contained_objects)

    def get_area(self) -> float:
        """Return the area of a plane [m^2], or the volume of a box [m^3]."""
        size = np.ptp(self._boundary_bbox.corners, axis=0)
        return float(np.prod(size[:2] if self._is_plane else size))

    def add(
        self,
        obj: Object,
        ignore_collisions: bool = False,
        min_rotation: Sequence[float] = ANY_YAW[0],
        max_rotation: Sequence[float] = ANY_YAW[1],
        min_distance: float = 0.01,
        others: Sequence[Object] | None = None,
    ) -> int:
        """Try one random pose for an object, and move the object there if the pose is free.

        Args:
            obj: Object to place.
            ignore_collisions: Ignore objects that were placed before.
            min_rotation: Lower bounds of the rotation that is added: roll, pitch, yaw in the frame of the boundary [rad].
            max_rotation: Upper bounds of this rotation [rad].
            min_distance: Minimum distance between origins [m].
            others: Objects that were placed before; None: those of this boundary.

        Returns:
            1: placed; -1: it does not fit; -2: it would touch an object; -3: it would be too near to an object.
        """
        start = np.asarray(obj.get_pose(relative_to=self._boundary), dtype=float)
        turn = self.draw(np.asarray(min_rotation, dtype=float), np.asarray(max_rotation, dtype=float))
        quaternion = rotated(turn, start[3:])
        own = self._box(obj)
        box = own.rotate(quaternion)
        position = np.asarray(self._get_position_within_boundary(obj, box), dtype=float)
        if not box.moved(position).within_boundary(self._boundary_bbox, self._is_plane):
            return TOO_BIG
        local = np.concatenate([position, quaternion])
        if not ignore_collisions:
            present = self._contained_objects if others is None else others
            refusal = self._refusal(OrientedBox.of(own.corners, local), position, present, min_distance)
            if refusal is not None:
                return refusal
        obj.set_pose(local, relative_to=self._boundary)
        self._contained_objects.append(obj)
        return PLACED

    def _refusal(self, box: OrientedBox, position: FloatArray, others: Sequence[Object], min_distance: float) -> int | None:
        """Return `TOUCHES` or `TOO_NEAR` if a pose is not free, otherwise None."""
        for other in others:
            pose = np.asarray(other.get_pose(relative_to=self._boundary), dtype=float)
            if box.overlaps(OrientedBox.of(self._box(other).corners, pose)):
                return TOUCHES
            if np.linalg.norm(position - pose[:3]) < min_distance:
                return TOO_NEAR
        return None

    def _box(self, obj: Object) -> BoundingBox:
        """Return the box around an object in its own frame."""
        return bounding_box(obj)

    def draw(self, low: FloatArray, high: FloatArray) -> FloatArray:
        """Return random numbers (n,), uniform between their bounds."""
        return np.random.uniform(low, high)

    def _get_position_within_boundary(self, obj: Object, obj_bbox: BoundingBox) -> list[float]:
        """Return a random position [x, y, z] for an object in the frame of the boundary [m].

        Args:
            obj: Object to place; on a plane it keeps its height.
            obj_bbox: Box around the object along the axes of the boundary, relative to the origin of the object.
        """
        low = self._boundary_bbox.corners[0] - obj_bbox.corners[0]
        high = self._boundary_bbox.corners[1] - obj_bbox.corners[1]
        place = self.draw(np.minimum(low, high), np.maximum(low, high))
        if self._is_plane:
            place[2] = obj.get_position(relative_to=self._boundary)[2]
        return [float(x) for x in place]

    def clear(self) -> None:
        """Remove all objects from the list of placed objects."""
        self._contained_objects = []


class SpawnBoundary:
    """Places objects at random poses inside one or several boundaries, without contacts between them.

    Args:
        boundaries: Regions of the scene, as `Shape('boundary')`.
    """

    MAX_SAMPLES = MAX_SAMPLES

    def __init__(self, boundaries: Sequence[Object]) -> None:
        self._boundaries = [BoundaryObject(boundary) for boundary in boundaries]
        if not self._boundaries:
            raise TaskError("SpawnBoundary needs at least one boundary, such as [Shape('boundary')].")
        areas = np.array([boundary.get_area() for boundary in self._boundaries])
        self._probabilities = areas / areas.sum() if areas.sum() > 0.0 else np.full(len(areas), 1.0 / len(areas))

    def sample(
        self,
        obj: Object,
        ignore_collisions: bool = False,
        min_rotation: Sequence[float] = ANY_YAW[0],
        max_rotation: Sequence[float] = ANY_YAW[1],
        min_distance: float = 0.01,
    ) -> None:
        """Move an object to a random free pose.

        Args:
            obj: Object to place.
            ignore_collisions: Ignore objects that were placed before.
            min_rotation: Lower bounds of the rotation that is added: roll, pitch, yaw [rad].
            max_rotation: Upper bounds of this rotation [rad].
            min_distance: Minimum distance between origins of placed objects [m].

        Raises:
            BoundaryError: No free pose was found in `MAX_SAMPLES` tries.
        """
        others = [item for boundary in self._boundaries for item in boundary.contained_objects]
        answers = []
        for _ in range(self.MAX_SAMPLES):
            answers.append(self._choose().add(obj, ignore_collisions, min_rotation, max_rotation, min_distance, others))
            if answers[-1] > 0:
                return
        raise BoundaryError(
            f"'{obj.get_name()}' found no place in {len(answers)} tries: {answers.count(TOO_BIG)} times it did not fit, "
            f"{answers.count(TOUCHES)} times it would touch what was placed before, {answers.count(TOO_NEAR)} times it was "
            f"within {min_distance} m of it. Call clear() at the start of every episode, or enlarge the boundary."
        )

    def _choose(self) -> BoundaryObject:
        """Return a random boundary, with probabilities proportional to the areas or volumes."""
        return self._boundaries[int(np.random.choice(len(self._boundaries), p=self._probabilities))]

    def clear(self) -> None:
        """Remove all objects from the lists of placed objects; call it at the start of each episode."""
        for boundary in self._boundaries:
            boundary.clear()


def bounding_box(obj: Object) -> BoundingBox:
    """Return the box around an object in its own frame; for an object that is not a shape it is a point."""
    if not isinstance(obj, Shape):
        return BoundingBox(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    bounds = obj.get_model_bounding_box() if obj.is_model() else obj.get_bounding_box()
    return BoundingBox(*(float(bound) for bound in bounds))


class WorkspaceArea(BoundaryObject):
    """The plane of the workspace. Only the footprint of an object has to fit.

    The draws are those of the native placement, so a seed gives the same pose with both.

    Attributes:
        rng: Random generator; None is numpy's global generator.
    """

    rng: np.random.Generator | None = None

    def _box(self, obj: Object) -> BoundingBox:
        """Return the footprint of an object, without height."""
        world, element = Simulator.current().runtime.world, obj.element
        name = element.name.partition("/")[0]
        if element.kind == "root" or world.spec.placement.footprint is not None:
            low, high = footprint(world)
        elif name in world.bodies:
            low, high = world.bodies[name].bounds()
        else:
            high = 0.5 * np.asarray(getattr(world.frames.get(name), "size", np.zeros(3)), dtype=float)
            low = -high
        return BoundingBox(float(low[0]), float(high[0]), float(low[1]), float(high[1]), 0.0, 0.0)

    def draw(self, low: FloatArray, high: FloatArray) -> FloatArray:
        """Return random numbers (n,) from `rng`, uniform between their bounds."""
        return super().draw(low, high) if self.rng is None else self.rng.uniform(low, high)

    def _get_position_within_boundary(self, obj: Object, obj_bbox: BoundingBox) -> list[float]:
        """Return a random position [x, y, z] for an object in the frame of the plane [m]; the middle if it does not fit."""
        low = (self._boundary_bbox.corners[0] - obj_bbox.corners[0])[:2]
        high = (self._boundary_bbox.corners[1] - obj_bbox.corners[1])[:2]
        x, y = self.draw(low, high) if np.all(low <= high) else (low + high) / 2.0
        return [float(x), float(y), float(obj.get_position(relative_to=self._boundary)[2])]


class Workspace(SpawnBoundary):
    """The boundary of all placements of a task.

    Args:
        plane: The workspace of the scene.
    """

    def __init__(self, plane: Shape) -> None:
        super().__init__([plane])
        self._area = WorkspaceArea(plane)
        self._boundaries = [self._area]

    def _choose(self) -> BoundaryObject:
        return self._boundaries[0]

    @contextmanager
    def drawing_from(self, rng: np.random.Generator | None) -> Iterator[None]:
        """Draw from `rng` within a `with` block; None is numpy's global generator."""
        before, self._area.rng = self._area.rng, rng
        try:
            yield
        finally:
            self._area.rng = before
