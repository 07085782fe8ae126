"""What bodies have and frames have not: an extent."""

from __future__ import annotations

from functools import cache
from typing import Protocol, runtime_checkable

from rlbench_pin.spatial import FloatArray


@runtime_checkable
class Solid(Protocol):
    """Something with an extent, such as a body; frames, regions and sensors are points."""

    def bounds(self) -> FloatArray:
        """Return the lowest and highest corner (2, 3) of the box around it, in its own frame [m]."""
        ...


def is_solid(thing: object) -> bool:
    """Say whether a thing has an extent; asked in every tick, so that each class is looked at once."""
    kind: object = type(thing)
    return _is_solid(kind)


@cache
def _is_solid(kind: object) -> bool:
    return isinstance(kind, type) and issubclass(kind, Solid)
