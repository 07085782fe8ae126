"""What bodies have and frames have not: an extent."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from rlbench_pin.spatial import FloatArray


@runtime_checkable
class Solid(Protocol):
    """Something with an extent, such as a body; frames, regions and sensors are points."""

    def bounds(self) -> FloatArray:
        """Return the lowest and highest corner (2, 3) of the box around it, in its own frame [m]."""
        ...
