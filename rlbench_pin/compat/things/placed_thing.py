"""Things beside the physics, as things."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np

from rlbench_pin.compat.things.element import Element
from rlbench_pin.compat.things.placed import Placed
from rlbench_pin.compat.things.thing import Solid, Thing, box_part
from rlbench_pin.spatial import FloatArray, compose, relative


class PlacedHome(Protocol):
    """The table that keeps placed things."""

    placed: dict[str, Placed]

    def thing(self, element: Element) -> Thing:
        """Return what answers for an element."""
        ...

    def carry(self, element: Element, old: FloatArray, new: FloatArray) -> None:
        """Move what hangs on an element."""
        ...


class PlacedThing(Thing):
    """A dummy, camera, path or plane that a program or the fixed scene placed."""

    def __init__(self, home: PlacedHome, name: str) -> None:
        self._home, self._name = home, name
        self.type = home.placed[name].kind

    @property
    def placed(self) -> Placed:
        """What is kept of it."""
        return self._home.placed[self._name]

    @property
    def pose(self) -> FloatArray:
        """Pose (7,) in the world."""
        placed = self.placed
        return placed.local.copy() if placed.parent is None else compose(self._home.thing(placed.parent).pose, placed.local)

    def set_pose(self, pose: FloatArray, zero_velocity: bool) -> None:
        """Move it and what hangs on it."""
        old, placed = self.pose, self.placed
        local = pose if placed.parent is None else relative(pose, self._home.thing(placed.parent).pose)
        self._home.placed[self._name] = replace(placed, local=np.array(local))
        if not np.array_equal(old, pose):
            self._home.carry(Element("placed", self._name), old, pose)

    def solids(self) -> list[Solid]:
        """The plane of a shape."""
        return [((box_part(np.array(self.placed.size)),), self.pose)] if self.type == "shape" else []

    def box(self) -> FloatArray:
        """The box of a plane."""
        half = 0.5 * np.array(self.placed.size)
        return np.stack([-half, half])
