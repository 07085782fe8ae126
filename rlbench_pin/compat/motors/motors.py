"""What motors offer, and what they keep that our world has no word for: force caps, and the velocities that were asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from rlbench_pin.spatial import FloatArray

Numbers = Sequence[float] | FloatArray


class Motors(Protocol):
    """The motors of one component; every vector has one number per joint."""

    def positions(self) -> FloatArray:
        """Measured positions (n,) [rad] or [m]."""
        ...

    def velocities(self) -> FloatArray:
        """Measured velocities (n,) [rad/s] or [m/s]."""
        ...

    def forces(self) -> FloatArray:
        """Forces (n,) of the motors in the last physics step [N m] or [N]."""
        ...

    def limits(self) -> FloatArray:
        """Lowest and highest positions, shape (2, n), [rad] or [m]."""
        ...

    def velocity_limits(self) -> FloatArray:
        """Largest speeds (n,) [rad/s] or [m/s]."""
        ...

    def teleport(self, positions: Numbers) -> None:
        """Put the joints at positions (n,) [rad] or [m], at rest."""
        ...

    def target_positions(self) -> FloatArray:
        """Where the motors go (n,) [rad] or [m]."""
        ...

    def set_target_positions(self, positions: Numbers) -> None:
        """Go to positions (n,) [rad] or [m] in the coming ticks."""
        ...

    def target_velocities(self) -> FloatArray:
        """Velocities (n,) that were asked for [rad/s] or [m/s]."""
        ...

    def set_target_velocities(self, velocities: Numbers) -> None:
        """Move at velocities (n,) [rad/s] or [m/s] until the next command."""
        ...

    def set_forces(self, forces: Numbers) -> None:
        """Cap the motors' forces (n,) [N m] or [N]."""
        ...

    def control_loop(self) -> bool:
        """Whether positions are controlled."""
        ...

    def set_control_loop(self, enabled: bool) -> None:
        """Control positions; otherwise velocities, zero at first."""
        ...


@dataclass
class Asked:
    """What was asked of the motors of one runtime."""

    velocities: FloatArray
    """Target velocities (n,)."""
    forces: FloatArray
    """Force caps (n,)."""


def vector(numbers: Numbers, size: int, what: str) -> FloatArray:
    """Return `size` finite numbers, or raise ValueError."""
    values = np.array(numbers, dtype=float)
    if values.shape != (size,) or not np.isfinite(values).all():
        raise ValueError(f"{what}: {size} finite numbers are needed, not {numbers!r}.")
    return values
