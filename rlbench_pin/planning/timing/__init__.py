"""From paths to trajectories, within the limits of joints and motors."""

from __future__ import annotations

from rlbench_pin.planning.timing.arc import ArcLimits
from rlbench_pin.planning.timing.retime import retime
from rlbench_pin.planning.timing.torque import TorqueLimits

__all__ = [
    "ArcLimits",
    "TorqueLimits",
    "retime",
]
