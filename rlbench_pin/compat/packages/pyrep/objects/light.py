"""Lights of the scene: not things here."""

from __future__ import annotations

from pyrep.errors import UnsupportedCall
from pyrep.objects.object import Object


class Light(Object):
    """Refused: lights are a setting of pictures, not things with a name."""

    def __init__(self, name_or_handle: str | int) -> None:
        raise UnsupportedCall(
            f"Light({name_or_handle!r})",
            "lights are settings here.",
            "Set `ObservationConfig.lighting`, an `rlbench_pin.sim.Lighting`.",
        )
