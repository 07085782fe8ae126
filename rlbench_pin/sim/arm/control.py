"""The command of the arm's motors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from rlbench_pin.spatial import FloatArray

DriveMode = Literal["position", "velocity", "torque"]
"""What the arm's motors follow."""


@dataclass(frozen=True, eq=False)
class ArmControl:
    """Command of the arm's motors: enough to continue exactly."""

    mode: DriveMode
    target: FloatArray
    """Positions [rad], velocities [rad/s] or torques [N m], shape (n,)."""
    reference: FloatArray
    """How far the interpolation towards a position target has come [rad], shape (n,)."""
    torques: FloatArray | None = None
    """Torques of the last tick where they were commanded, for the simulator does not report those [N m], shape (n,)."""
