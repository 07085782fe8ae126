"""Snapshot of the world for planning: names, model files, poses and joint positions at one instant."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from rlbench_pin.errors import InvalidValue
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_names, as_number, as_pose, as_rows, as_vector

NO_FILE = Path()
"""Model file of a body that brings its own shapes."""
ROOM = ("table", "floor", "wall_front", "wall_back", "wall_left", "wall_right", "ceiling")
"""Names of the bodies that every world has, in mask order; no body of a scene may be called so."""

Box = tuple[ArrayLike, ArrayLike]
"""Sides (3,) [m], and position (3,) [m] or pose (7,) of the middle, in the world."""
CELL = 0.025
"""Side of the cubes that represent a point cloud [m]."""
LONGEST = 4
"""Number of cubes in a row that are joined to one box at most, so that a body that may be touched is a small one."""
FEWEST = 2
"""Cubes with fewer points are noise."""


@dataclass(frozen=True)
class Shape:
    """A solid in the frame of its body, as plain numbers."""

    kind: Literal["box", "cylinder", "sphere", "capsule", "convex"]
    """Which solid."""
    size: tuple[float, ...]
    """box: x, y, z; cylinder, capsule: radius, length along z without caps; sphere: radius; convex: x, y, z of corners [m]."""
    pose: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
    """Placement (7,) in the frame of the link."""


@dataclass(frozen=True, eq=False)
class BodySnapshot:
    """One object: its model file or its shapes, and the pose of each link."""

    name: str
    """Name in the scene, or of a part of the room."""
    urdf: Path
    """Model file, or `NO_FILE`."""
    link_names: tuple[str, ...]
    """Links that carry collision geometry, base first."""
    link_poses: FloatArray
    """Pose of each link frame (the URDF frame, not the inertial one) in the world, shape (n, 7)."""
    scale: float = 1.0
    """Factor of all lengths of the model file."""
    collides: bool = True
    """Whether anything can touch it."""
    fixed: bool = False
    """Whether it cannot move."""
    shapes: tuple[Shape, ...] = ()
    """Shapes of the only link, instead of those of a model file."""
    in_room: bool = False
    """Whether it belongs to the room: it stays solid when touching is allowed, and is left out where the arm cannot reach."""
    masses: Mapping[str, float] = field(default_factory=dict)
    """Masses of links that differ from the model file [kg]."""

    @property
    def layout(self) -> tuple[object, ...]:
        """Key of the shapes without poses: equal for bodies that differ only in poses."""
        return self.name, self.urdf, self.scale, self.link_names, self.shapes, self.in_room


@dataclass(frozen=True, eq=False)
class WorldSnapshot:
    """All bodies except the robot, the configuration of the robot, and the bodies that the gripper holds."""

    bodies: tuple[BodySnapshot, ...]
    """In the order of the world: room first."""
    arm: FloatArray
    """Arm joint positions [rad], shape (n,)."""
    fingers: FloatArray
    """Finger joint positions [m]."""
    attached: tuple[str, ...] = ()
    """Names of the bodies fixed to the gripper."""

    def body(self, name: str) -> BodySnapshot:
        """Return the body called `name`."""
        return next(b for b in self.bodies if b.name == name)

    def configuration(self) -> FloatArray:
        """Return arm and finger positions as one vector."""
        return np.concatenate([self.arm, self.fingers])

    # Made from what a robot perceives ---------------------------------------------------------------------------------

    @classmethod
    def from_boxes(
        cls, boxes: Mapping[str, Box], arm: ArrayLike, fingers: ArrayLike = (0.04, 0.04), attached: Sequence[str] = ()
    ) -> WorldSnapshot:
        """Return a world of boxes, for planning without a simulator.

        Args:
            boxes: Name -> sides (3,) [m], and position (3,) or pose (7,) of the centre. Boxes with the name of a part of the
                room, such as `table`, stay obstacles where contact with objects is allowed.
            arm: Arm joint positions (n,) [rad].
            fingers: Finger joint positions (2,) [m]; by default those of the open gripper of the Panda.
            attached: Names of the boxes that the gripper holds.

        Raises:
            InvalidValue: A number is NaN, a side is not positive, a shape is wrong, or an attached name is not that of a box
                (also a ValueError).
        """
        held = as_names(attached, "attached")
        if unknown := [name for name in held if name not in boxes]:
            raise InvalidValue("attached", unknown, f"has to be names of boxes. Known: {', '.join(boxes) or 'none'}")
        bodies = tuple(_box(name, box, name in held) for name, box in boxes.items())
        return cls(bodies, np.array(arm, dtype=float), np.array(fingers, dtype=float), held)

    @classmethod
    def from_point_cloud(
        cls,
        points: ArrayLike,
        arm: ArrayLike,
        fingers: ArrayLike = (0.04, 0.04),
        *,
        boxes: Mapping[str, Box] | None = None,
        attached: Sequence[str] = (),
        cell: float = CELL,
        fewest: int = FEWEST,
    ) -> WorldSnapshot:
        """Return a world of known boxes and of solid cubes where points are.

        The points must not include the arm, nor the objects of the boxes. Space behind surfaces counts as free.

        Args:
            points: Points in the world, shape (n, 3) [m].
            arm: Arm joint positions (n,) [rad].
            fingers: Finger joint positions (2,) [m]; by default those of the open gripper of the Panda.
            boxes: Known boxes, as in `from_boxes`: the table, the object to grasp.
            attached: Names of the boxes that the gripper holds.
            cell: Side of the cubes of the grid [m].
            fewest: Smallest number of points in a solid cube.

        Returns:
            A world with the boxes and then the bodies `points 0`, `points 1`, ..., each of a few cubes.

        Raises:
            InvalidValue: As in `from_boxes`, or the points are not a finite array (n, 3) (also a ValueError).
        """
        corners = solid_boxes(as_rows(points, 3, "points", least=0), as_number(cell, "cell", above=0.0), fewest)
        seen = {f"points {k}": (high - low, 0.5 * (low + high)) for k, (low, high) in enumerate(corners)}
        return cls.from_boxes({**(boxes or {}), **seen}, arm, fingers, attached)


def _box(name: str, box: Box, held: bool) -> BodySnapshot:
    """Return a box as a fixed body, or a movable one if it is attached."""
    sides, place = (np.asarray(value, dtype=float) for value in box)
    what = f"the box '{name}'"
    size = as_vector(sides, 3, f"the sides of {what}")
    if size.min() <= 0.0:
        raise InvalidValue(f"the sides of {what}", sides, "have to be positive")
    pose = as_pose(np.concatenate([place, [0.0, 0.0, 0.0, 1.0]]) if place.shape == (3,) else place, f"the pose of {what}")
    shape = Shape("box", (float(size[0]), float(size[1]), float(size[2])))
    return BodySnapshot(name, NO_FILE, ("base",), pose[None], fixed=not held, shapes=(shape,), in_room=name in ROOM)


def solid_boxes(points: FloatArray, cell: float = CELL, fewest: int = FEWEST) -> FloatArray:
    """Return boxes that cover exactly the cubes with points, as lowest and highest corners (m, 2, 3) [m].

    Args:
        points: Points (n, 3) [m].
        cell: Side of the cubes [m].
        fewest: Smallest number of points in a covered cube.
    """
    cells, counts = np.unique(np.floor(points / cell).astype(np.int64), axis=0, return_counts=True)
    cells = cells[counts >= fewest]
    boxes = np.stack([cells, cells + 1], axis=1)
    for axis in (2, 0, 1):
        boxes = _joined(boxes, axis)
    return cell * boxes.astype(float)


def _joined(boxes: np.ndarray, axis: int) -> np.ndarray:
    """Join adjacent boxes (m, 2, 3) of one cross-section along an axis, up to the next multiple of `LONGEST`."""
    others = [i for i in range(3) if i != axis]
    section = boxes[:, :, others].reshape(-1, 4)
    order = np.lexsort((boxes[:, 0, axis], *section.T))
    boxes, section = boxes[order], section[order]
    continues = (section[1:] == section[:-1]).all(axis=1) & (boxes[1:, 0, axis] == boxes[:-1, 1, axis])
    continues &= boxes[1:, 0, axis] % LONGEST != 0
    first, last = np.append(True, ~continues)[: len(boxes)], np.append(~continues, True)[: len(boxes)]
    joined = boxes[first].copy()
    joined[:, 1] = boxes[last][:, 1]
    return joined
