"""Named places relative to a parent, and boxes to sample in."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
import pinocchio as pin

from rlbench_pin.scene.spec import WORLD
from rlbench_pin.sim.checks import finite_vector, pose_vector
from rlbench_pin.spatial import FloatArray, PoseLike, pose_to_se3, se3_to_pose
from rlbench_pin.values import as_flag


class Posed(Protocol):
    """Something with a name and a movable place in the world: a body or a frame."""

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
        """Move to a world pose (7,)."""
        ...


class Places(Protocol):
    """What a frame needs of its world."""

    def placement(self, name: str) -> pin.SE3:
        """Return T_world_x of a body, a link, a frame, `root` or `world`."""
        ...

    def carry(self, name: str, old: FloatArray, new: FloatArray) -> None:
        """Move the bodies whose parent, near or far, is `name`, which went from pose `old` to `new`."""
        ...

    def check_parent(self, child: str, parent: str) -> None:
        """Raise when `parent` is unknown or a descendant of `child`."""
        ...


class Frame:
    """A place that keeps its pose relative to its parent.

    Args:
        name: Name in the scene file.
        parent: `root`, `world`, `<body>`, `<body>/<link>` or the name of another frame.
        local: Pose (7,) in the frame of the parent.
        places: The world it lies in.
    """

    def __init__(self, name: str, parent: str, local: PoseLike, places: Places) -> None:
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
        """Name of what the frame moves with."""
        return self._parent

    def set_pose(self, pose: PoseLike) -> None:
        """Move the frame to a world pose (7,); the parent stays, and bodies whose parent it is move along."""
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
        """Move the origin to a world point (3,) [m]; the orientation stays."""
        point = finite_vector(position, 3, f"position of '{self.name}'")
        self.set_pose(np.concatenate([point, self.pose[3:]]))

    def move_to(self, target: Posed | PoseLike | str) -> None:
        """Move to where a body or another frame is, to the place of that name, or to a world pose (7,)."""
        there = se3_to_pose(self._places.placement(target)) if isinstance(target, str) else target
        self.set_pose(getattr(there, "pose", there))  # type: ignore[arg-type]

    def set_parent(self, parent: str, keep_in_place: bool = False) -> None:
        """Give the frame another parent.

        Args:
            parent: Name of the new parent.
            keep_in_place: Stay where it is in the world; otherwise keep the pose relative to the parent, as a scene file would.
        """
        keep_in_place = as_flag(keep_in_place, "keep_in_place")
        self._places.check_parent(self.name, parent)
        pose = self.pose
        self._parent = parent
        if keep_in_place:
            self.set_pose(pose)

    def state(self) -> tuple[str, FloatArray]:
        """Parent and local pose."""
        return self._parent, self._local

    def set_state(self, parent: str, local: FloatArray) -> None:
        """Set parent and local pose, and move nothing else."""
        if parent != self._parent or local is not self._local:
            self._parent = parent
            self._set_local(local)

    def __repr__(self) -> str:
        return f"{type(self).__name__}('{self.name}' on '{self._parent}')"


class Region(Frame):
    """A box around a frame in which things are placed; flat when its height is 0.

    Args:
        size: Lengths (3,) along the frame's axes [m].
    """

    def __init__(self, name: str, parent: str, local: PoseLike, places: Places, size: Sequence[float]) -> None:
        super().__init__(name, parent, local, places)
        self.size: FloatArray = np.array(size, dtype=float)
        self.size.setflags(write=False)
