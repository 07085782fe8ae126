"""What hangs on what: frames, bodies, and the root that holds them."""

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
    """Resolves names to placements, and moves bodies with what they hang on.

    Args:
        spec: Names, parents and local poses.
        find: Looks a body up by name.
    """

    def __init__(self, spec: SceneSpec, find: Callable[[str], Body]) -> None:
        self._find = find
        self._hanging: dict[str, BodySpec] = {}
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
        if name not in self.frames:
            raise UnknownName("frame of this scene", name, tuple(self.frames))
        return self.frames[name]

    def frame_of_kind(self, name: str, kind: type[Kind], word: str) -> Kind:
        """Return a region or a sensor."""
        found = self.frames.get(name)
        if not isinstance(found, kind):
            raise UnknownName(f"{word} of this scene", name, [n for n, f in self.frames.items() if isinstance(f, kind)])
        return found

    def knows(self, name: str) -> bool:
        """Whether a frame or a hanging body has that name."""
        return name in self.frames or name in self._hanging or name == WORLD

    def placement(self, name: str) -> pin.SE3:
        """Return T_world_x of a body, a link, a frame, `root` or `world`."""
        if name in self.frames:
            return self.frames[name].placement()
        if name == WORLD:
            return pin.SE3.Identity()
        body, _, link = name.partition("/")
        found = self._find_body(body)
        return pose_to_se3(found.link_pose(link) if link else found.pose)

    def _find_body(self, name: str) -> Body:
        try:
            return self._find(name)
        except UnknownName as error:
            raise UnknownName("place of this scene", name, (*error.known, *self.frames, WORLD)) from error

    # What hangs on what ----------------------------------------------------------------------------------------------

    def hang(self, spec: BodySpec) -> None:
        """Make a body hang on its parent."""
        self._hanging[spec.name] = spec

    def unhang(self, name: str) -> None:
        """Forget a body."""
        del self._hanging[name]

    def place_bodies(self) -> None:
        """Put every body where the scene file says, parents first."""
        for name in sorted(self._hanging, key=lambda n: len(self._owners(n))):
            self.place_body(name)

    def place_body(self, name: str) -> None:
        """Put one body at its pose relative to its parent."""
        spec = self._hanging[name]
        self._find(name).place(se3_to_pose(self.placement(spec.parent) * pose_to_se3(spec.pose)))

    def carry(self, name: str, old: FloatArray, new: FloatArray) -> None:
        """Move the bodies that hang on `name`, directly or not, which went from pose `old` to `new`; they come to rest."""
        if np.array_equal(old, new):
            return
        for body_name in self._hanging:
            if name in self._owners(body_name):
                body = self._find(body_name)
                body.place(carried(body.pose, old, new))

    def check_parent(self, child: str, parent: str) -> None:
        """Raise when `parent` is unknown or hangs on `child`."""
        self.placement(parent)
        owner = parent.partition("/")[0]
        if owner == child or child in self._owners(owner):
            raise RlbenchPinError(f"'{child}' cannot hang on '{parent}', which hangs on '{child}' itself.")

    def _owners(self, name: str) -> tuple[str, ...]:
        """Names of all that `name` hangs on, nearest first."""
        owners: list[str] = []
        while (parent := self._parent(name)) is not None:
            owners.append(parent)
            name = parent
        return tuple(owners)

    def _parent(self, name: str) -> str | None:
        things: Mapping[str, Frame | BodySpec] = self.frames if name in self.frames else self._hanging
        return things[name].parent.partition("/")[0] if name in things else None
