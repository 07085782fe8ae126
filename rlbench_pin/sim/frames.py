"""Frames, regions and sensors relative to a parent, and the tree of parents and children."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Literal, Protocol, TypeVar

import numpy as np
import pinocchio as pin

from rlbench_pin.errors import RlbenchPinError, UnknownName
from rlbench_pin.robot import geometry
from rlbench_pin.scene.spec import ROOT, WORLD, BodySpec, SceneSpec
from rlbench_pin.sim.body import Body, carried
from rlbench_pin.spatial import FloatArray, PoseLike, pose_to_se3, se3_to_pose
from rlbench_pin.values import as_flag, as_text, finite_vector, pose_vector


class Posed(Protocol):
    """An element with a name and a pose in the world that can change: a body or a frame."""

    name: str

    @property
    def pose(self) -> FloatArray:
        """Pose (7,) in the world."""
        ...

    @property
    def position(self) -> FloatArray:
        """Origin (3,) in the world [m]."""
        ...

    @property
    def quaternion(self) -> FloatArray:
        """Orientation (4,) in the world, [qx, qy, qz, qw]."""
        ...

    def set_pose(self, pose: PoseLike) -> None:
        """Set the world pose (7,)."""
        ...


class Frame:
    """A coordinate frame with a fixed pose relative to its parent.

    Args:
        name: Name in the scene file.
        parent: `root`, `world`, `<body>`, `<body>/<link>` or the name of another frame.
        local: Pose (7,) in the frame of the parent.
        places: The tree of frames of the world.
    """

    def __init__(self, name: str, parent: str, local: PoseLike, places: PlaceTree) -> None:
        self.name = name
        self._places = places
        self._parent = parent
        self._set_local(np.array(local, dtype=float))

    def _set_local(self, local: FloatArray) -> None:
        self._local = local
        self._T_parent_frame = pose_to_se3(local)

    def placement(self) -> pin.SE3:
        """Return T_world_frame."""
        if self._parent == WORLD:
            return self._T_parent_frame.copy()
        return self._places.placement(self._parent) * self._T_parent_frame

    @property
    def pose(self) -> FloatArray:
        """Pose (7,) in the world."""
        return se3_to_pose(self.placement())

    @property
    def position(self) -> FloatArray:
        """Origin (3,) in the world [m]."""
        return np.array(self.placement().translation)

    @property
    def quaternion(self) -> FloatArray:
        """Orientation (4,) in the world, [qx, qy, qz, qw]."""
        return self.pose[3:]

    @property
    def local(self) -> FloatArray:
        """Pose (7,) in the frame of the parent."""
        return self._local.copy()

    @property
    def parent(self) -> str:
        """Name of the parent."""
        return self._parent

    def set_pose(self, pose: PoseLike) -> None:
        """Set the world pose (7,) of the frame; the parent does not move, and child bodies move along."""
        new, old = pose_vector(pose, f"pose of '{self.name}'"), self.pose
        if self._parent == WORLD:
            self._set_local(new)
        else:
            self._set_local(se3_to_pose(self._places.placement(self._parent).actInv(pose_to_se3(new))))
        self._places.carry(self.name, old, new)

    def set_local(self, local: PoseLike) -> None:
        """Set the pose (7,) in the frame of the parent."""
        old = self.pose
        self._set_local(pose_vector(local, f"local pose of '{self.name}'"))
        self._places.carry(self.name, old, self.pose)

    def set_position(self, position: Sequence[float] | FloatArray) -> None:
        """Move the origin to a world point (3,) [m]; the orientation does not change."""
        point = finite_vector(position, 3, f"position of '{self.name}'")
        self.set_pose(np.concatenate([point, self.pose[3:]]))

    def move_to(self, target: Posed | PoseLike | str) -> None:
        """Move to the pose of a body or another frame, given as object or name, or to a world pose (7,)."""
        there = se3_to_pose(self._places.placement(target)) if isinstance(target, str) else target
        self.set_pose(getattr(there, "pose", there))  # type: ignore[arg-type]

    def set_parent(self, parent: str, keep_in_place: bool = False) -> None:
        """Give the frame another parent.

        Args:
            parent: Name of the new parent.
            keep_in_place: Keep the world pose; otherwise keep the pose relative to the parent, as in a scene file.
        """
        keep_in_place = as_flag(keep_in_place, "keep_in_place")
        self._places.check_parent(self.name, parent)
        pose = self.pose
        self._parent = parent
        if keep_in_place:
            self.set_pose(pose)

    def moves_with(self, name: str) -> bool:
        """Whether the body or frame `name` is the parent or another ancestor."""
        return self._places.is_below(self.name, as_text(name, "name"))

    def state(self) -> tuple[str, FloatArray]:
        """Parent and local pose."""
        return self._parent, self._local

    def set_state(self, parent: str, local: FloatArray) -> None:
        """Set parent and local pose; no other element moves."""
        if parent != self._parent or local is not self._local:
            self._parent = parent
            self._set_local(local)

    def __repr__(self) -> str:
        return f"{type(self).__name__}('{self.name}' on '{self._parent}')"


class Region(Frame):
    """A box around a frame in which objects are placed; flat when its height is 0.

    Args:
        size: Lengths (3,) along the frame's axes [m].
    """

    def __init__(self, name: str, parent: str, local: PoseLike, places: PlaceTree, size: Sequence[float]) -> None:
        super().__init__(name, parent, local, places)
        self.size: FloatArray = np.array(size, dtype=float)
        self.size.setflags(write=False)


Shape = Literal["box", "cylinder", "sphere"]


class Sensor(Frame):
    """A box, cylinder or sphere that detects the bodies in it; contact with its surface suffices.

    Args:
        shape: Kind of volume.
        size: box: x, y, z; cylinder: diameter, length along z; sphere: diameter [m].
        find: Looks up a body by name.
    """

    def __init__(
        self,
        name: str,
        parent: str,
        local: PoseLike,
        places: PlaceTree,
        *,
        shape: Shape,
        size: Sequence[float],
        find: Callable[[str], Body],
    ) -> None:
        super().__init__(name, parent, local, places)
        self.shape: Shape = shape
        self.size = tuple(float(s) for s in size)
        self._volume = geometry.volume(shape, self.size)
        self._reach = geometry.radius(self._volume)
        self._find = find

    def detects(self, body: str) -> bool:
        """Return whether any solid part of a body is in the volume; a body without collision geometry counts with its visuals.

        Args:
            body: Name of the body.
        """
        return volume_meets(self._volume, self._reach, self.placement(), self._find(body))

    def contains(self, point: Sequence[float] | FloatArray) -> bool:
        """Return whether a world point (3,) [m] is in the volume."""
        x = finite_vector(point, 3, "point")
        return geometry.volume_contains(self.shape, self.size, self.placement(), np.asarray(x))


def volume_meets(volume: object, reach: float, T_world_volume: pin.SE3, body: Body) -> bool:
    """Return whether a Coal shape at a placement touches any solid part of a body.

    Args:
        volume: The shape.
        reach: Radius of its bounding sphere around its origin [m].
        T_world_volume: Its placement.
        body: The body.
    """
    for index, ball, parts in body.model.solids:
        T_world_link = body.model.placement(index)
        if geometry.is_near(ball, T_world_link, T_world_volume, reach) and geometry.overlaps(
            volume, T_world_volume, parts, T_world_link
        ):
            return True
    return False


Kind = TypeVar("Kind", bound=Frame)


class PlaceTree:
    """Tree of frames and bodies: resolves names to placements, and moves bodies with their parents.

    Args:
        spec: Names, parents and local poses.
        find: Looks up a body by name.
    """

    def __init__(self, spec: SceneSpec, find: Callable[[str], Body]) -> None:
        self._find = find
        self._bodies: dict[str, BodySpec] = {}
        self.frames: dict[str, Frame] = {ROOT: Frame(ROOT, WORLD, spec.placement.pose, self)}
        for f in (*spec.frame, *spec.waypoint):
            self.frames[f.name] = Frame(f.name, f.parent, f.pose, self)
        for region in spec.region:
            self.frames[region.name] = Region(region.name, region.parent, region.pose, self, region.size)
        for s in spec.sensor:
            self.frames[s.name] = Sensor(s.name, s.parent, s.pose, self, shape=s.shape, size=s.size, find=find)

    # Names -----------------------------------------------------------------------------------------------------------

    def frame(self, name: str) -> Frame:
        """Return a frame of any kind."""
        if not isinstance(name, str) or name not in self.frames:
            raise UnknownName("frame of this scene", name, tuple(self.frames))
        return self.frames[name]

    def frame_of_kind(self, name: str, kind: type[Kind], word: str) -> Kind:
        """Return a region or a sensor."""
        found = self.frames.get(name) if isinstance(name, str) else None
        if not isinstance(found, kind):
            raise UnknownName(f"{word} of this scene", name, [n for n, f in self.frames.items() if isinstance(f, kind)])
        return found

    def contains(self, name: str) -> bool:
        """Whether a frame or a body of the tree has that name."""
        return name in self.frames or name in self._bodies or name == WORLD

    def placement(self, name: str) -> pin.SE3:
        """Return T_world_x of a body, a link, a frame, `root` or `world`."""
        if not isinstance(name, str):
            self._find_body(name)  # says what there is
        if name in self.frames:
            return self.frames[name].placement()
        if name == WORLD:
            return pin.SE3.Identity()
        body, _, link = name.partition("/")
        found = self._find_body(body)
        return found.model.placement(found.model.link_index(link)) if link else found.model.placement()

    def _find_body(self, name: str) -> Body:
        try:
            return self._find(name)
        except UnknownName as error:
            raise UnknownName("place of this scene", name, (*error.known, *self.frames, WORLD)) from error

    # Parents and children --------------------------------------------------------------------------------------------

    def add_body(self, spec: BodySpec) -> None:
        """Make a body the child of its parent."""
        self._bodies[spec.name] = spec

    def remove_body(self, name: str) -> None:
        """Remove a body."""
        del self._bodies[name]

    def place_bodies(self) -> None:
        """Set the pose of every body from the scene file, parents first."""
        for name in sorted(self._bodies, key=lambda n: len(self._ancestors(n))):
            self.place_body(name)

    def place_body(self, name: str) -> None:
        """Set one body to its pose relative to its parent."""
        spec = self._bodies[name]
        self._find(name).place(se3_to_pose(self.placement(spec.parent) * pose_to_se3(spec.pose)))

    def carry(self, name: str, old: FloatArray, new: FloatArray) -> None:
        """Move the descendants of `name`, which moved from pose `old` to `new`; their velocities become zero."""
        if np.array_equal(old, new):
            return
        for body_name in self._bodies:
            if self.is_below(body_name, name):
                body = self._find(body_name)
                body.place(carried(body.pose, old, new))

    def check_parent(self, child: str, parent: str) -> None:
        """Raise when `parent` is unknown or a descendant of `child`."""
        self.placement(parent)
        owner = parent.partition("/")[0]
        if owner == child or child in self._ancestors(owner):
            raise RlbenchPinError(
                f"'{parent}' cannot be the parent of '{child}', because it is a descendant of '{child}'. Choose another parent."
            )

    def parent(self, name: str) -> str | None:
        """Return the name of the parent of a body or frame, as in a scene file; None without a parent."""
        if name in self.frames:
            return self.frames[name].parent
        return self._bodies[name].parent if name in self._bodies else None

    def set_parent(self, name: str, parent: str) -> None:
        """Set the parent of a body of the scene; the body does not move.

        Args:
            name: Name of the body.
            parent: `root`, `world`, `<body>`, `<body>/<link>` or the name of a frame.

        Raises:
            RlbenchPinError: The parent is a descendant of the body.
            UnknownName: There is no such parent, or no such body.
        """
        if name not in self._bodies:
            raise UnknownName("body of this scene", name, tuple(self._bodies))
        self.check_parent(name, parent)
        self._bodies[name] = self._bodies[name].model_copy(update={"parent": parent})

    def is_below(self, name: str, other: str) -> bool:
        """Whether `other` is an ancestor of `name`."""
        above = self._parent(name)
        while above is not None and above != other:
            above = self._parent(above)
        return above is not None

    def _ancestors(self, name: str) -> tuple[str, ...]:
        """Return the names of the ancestors of `name`, the parent first."""
        ancestors: list[str] = []
        while (parent := self._parent(name)) is not None:
            ancestors.append(parent)
            name = parent
        return tuple(ancestors)

    def _parent(self, name: str) -> str | None:
        elements: Mapping[str, Frame | BodySpec] = self.frames if name in self.frames else self._bodies
        return elements[name].parent.partition("/")[0] if name in elements else None
