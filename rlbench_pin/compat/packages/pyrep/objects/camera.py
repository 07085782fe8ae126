"""Cameras of the simulator's window: there is no window here."""

from __future__ import annotations

from pyrep.errors import UnsupportedCall
from pyrep.objects.object import Object


class Camera(Object):
    """Refused: there is no window."""

    def __init__(self, name_or_handle: str | int) -> None:
        raise UnsupportedCall(
            f"Camera({name_or_handle!r})", "there is no window to look through.", "Take pictures with a `VisionSensor`."
        )
