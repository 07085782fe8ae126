"""Proximity sensors: volumes that detect shapes."""

from __future__ import annotations

from typing import ClassVar

from pyrep.objects.object import Object
from rlbench_pin.compat.things import ObjectType, detection


class ProximitySensor(Object):
    """A box, cylinder or ball of the scene file that says what reaches into it; it looks at each call."""

    kinds: ClassVar[tuple[ObjectType, ...]] = ("proximity_sensor",)

    def read(self) -> float:
        """Return the distance from its origin to the nearest detectable body inside [m], -1 when there is none."""
        return detection.nearest(self.table, self.element)

    def is_detected(self, obj: Object) -> bool:
        """Say whether a thing reaches into the volume: any solid part of a shape, or the origin of another thing.

        Args:
            obj: What to look for; not detected while it is not detectable.
        """
        return obj.is_detectable() and detection.detects(self.table, self.element, obj.element)
