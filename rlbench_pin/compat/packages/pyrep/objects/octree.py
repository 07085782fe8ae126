"""Octrees: not part of the simulation here."""

from __future__ import annotations

from pyrep.errors import UnsupportedCall
from pyrep.objects.object import Object


class Octree(Object):
    """Refused: voxels are left to the programs that need them."""

    def __init__(self, name_or_handle: str | int) -> None:
        raise UnsupportedCall(
            f"Octree({name_or_handle!r})",
            "there are no voxels in the scene.",
            "Make them from `VisionSensor.capture_pointcloud`.",
        )
