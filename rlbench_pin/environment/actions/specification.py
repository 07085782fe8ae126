"""What the numbers of an action mean: names, units, frame, bounds and length in time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rlbench_pin.spatial import FloatArray

POSE_NAMES = ("x", "y", "z", "qx", "qy", "qz", "qw")
POSE_UNITS = ("m", "m", "m", "1", "1", "1", "1")
TWIST_NAMES = ("vx", "vy", "vz", "wx", "wy", "wz")
TWIST_UNITS = ("m/s", "m/s", "m/s", "rad/s", "rad/s", "rad/s")


@dataclass(frozen=True, eq=False)
class ActionSpec:
    """The numbers of one action, in order."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    low: FloatArray
    """Lowest values, shape (n,), read-only."""
    high: FloatArray
    """Highest values, shape (n,), read-only."""
    frame: str
    """Axes that Cartesian numbers are expressed in, or `joint`."""
    ticks: int | None
    """Control ticks that one action takes; None when that depends on the motion."""

    def __post_init__(self) -> None:
        if not len(self.names) == len(self.units) == len(self.low) == len(self.high):
            raise ValueError(
                f"{len(self.names)} names, {len(self.units)} units and {len(self.low)} bounds do not belong together"
            )
        for name in ("low", "high"):
            bound = np.array(getattr(self, name), dtype=float)
            bound.setflags(write=False)
            object.__setattr__(self, name, bound)

    @property
    def size(self) -> int:
        """How many numbers an action has."""
        return len(self.names)

    def joined(self, other: ActionSpec) -> ActionSpec:
        """Return the description of this action followed by another."""
        ticks = None if self.ticks is None or other.ticks is None else self.ticks + other.ticks
        return ActionSpec(
            (*self.names, *other.names),
            (*self.units, *other.units),
            np.concatenate([self.low, other.low]),
            np.concatenate([self.high, other.high]),
            self.frame,
            ticks,
        )
