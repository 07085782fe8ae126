"""Dummies: places without a shape."""

from __future__ import annotations

from typing import ClassVar

from pyrep.objects.object import Object
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.compat.things import Element, ObjectType, Placed
from rlbench_pin.spatial import IDENTITY


class Dummy(Object):
    """A frame or waypoint of the scene, the root of the task, the tip of the arm, or what a program made."""

    kinds: ClassVar[tuple[ObjectType, ...]] = ("dummy",)

    @classmethod
    def create(cls, size: float = 0.01) -> Dummy:
        """Make a dummy at the origin of the world.

        It stays until `remove()`. One that hangs on something of a task goes back with it at a reset to where it was when the
        task was set up, and is gone when it was made later, or when the task is.

        Args:
            size: Accepted; dummies are not drawn.
        """
        table = Simulator.current().objects
        name = table.free_name("Dummy")
        table.placed[name] = Placed("dummy", IDENTITY.copy(), extra={"size": size})
        return cls(Element("placed", name))

    def copy(self) -> Dummy:
        """Make another one at the same place, on the same parent."""
        made = Dummy.create()
        made.set_pose(self.get_pose())
        made.set_parent(self.get_parent())
        return made
