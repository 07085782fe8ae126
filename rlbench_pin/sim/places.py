"""The tree of parents and children: the root, frames and bodies."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeVar

import numpy as np
import pinocchio as pin

from rlbench_pin.errors import RlbenchPinError, UnknownName
from rlbench_pin.scene.spec import ROOT, WORLD, BodySpec, SceneSpec
from rlbench_pin.sim.bodies.body import Body, carried
from rlbench_pin.sim.frame import Frame, Region
from rlbench_pin.sim.sensor import Sensor
from rlbench_pin.spatial import FloatArray, pose_to_se3, se3_to_pose

Kind = TypeVar("Kind", bound=Frame)


class PlaceTree:
    """Resolves names to placements, and moves bodies with their parents.

    Args:
        spec: Names, parents and local poses.
        find: Looks a body up by name.
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
        """Forget a body."""
        del self._bodies[name]

    def place_bodies(self) -> None:
        """Put every body where the scene file says, parents first."""
        for name in sorted(self._bodies, key=lambda n: len(self._ancestors(n))):
            self.place_body(name)

    def place_body(self, name: str) -> None:
        """Put one body at its pose relative to its parent."""
        spec = self._bodies[name]
        self._find(name).place(se3_to_pose(self.placement(spec.parent) * pose_to_se3(spec.pose)))

    def carry(self, name: str, old: FloatArray, new: FloatArray) -> None:
        """Move the descendants of `name`, which went from pose `old` to `new`; they come to rest."""
        if np.array_equal(old, new):
            return
        for body_name in self._bodies:
            if self._is_below(body_name, name):
                body = self._find(body_name)
                body.place(carried(body.pose, old, new))

    def check_parent(self, child: str, parent: str) -> None:
        """Raise when `parent` is unknown or a descendant of `child`."""
        self.placement(parent)
        owner = parent.partition("/")[0]
        if owner == child or child in self._ancestors(owner):
            raise RlbenchPinError(
                f"'{parent}' cannot be the parent of '{child}', because it is a descendant of '{child}' itself."
            )

    def parent(self, name: str) -> str | None:
        """Return what a body or frame moves with, as a scene file says it; None for what has no parent."""
        if name in self.frames:
            return self.frames[name].parent
        return self._bodies[name].parent if name in self._bodies else None

    def set_parent(self, name: str, parent: str) -> None:
        """Let a body of the scene move with another thing from now on; it stays where it is.

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

    def _is_below(self, name: str, other: str) -> bool:
        """Whether `other` is the parent of `name`, or its parent, and so on."""
        above = self._parent(name)
        while above is not None and above != other:
            above = self._parent(above)
        return above is not None

    def _ancestors(self, name: str) -> tuple[str, ...]:
        """Names of the parent of `name`, of its parent, and so on."""
        ancestors: list[str] = []
        while (parent := self._parent(name)) is not None:
            ancestors.append(parent)
            name = parent
        return tuple(ancestors)

    def _parent(self, name: str) -> str | None:
        things: Mapping[str, Frame | BodySpec] = self.frames if name in self.frames else self._bodies
        return things[name].parent.partition("/")[0] if name in things else None
