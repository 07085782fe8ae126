"""From paths to trajectories, within the limits of joints and motors."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.front_door import front_door
from rlbench_pin.planning.timing.arc import ArcLimits
from rlbench_pin.planning.timing.retime import retime
from rlbench_pin.planning.timing.torque import TorqueLimits

__all__ = [
    "ArcLimits",
    "TorqueLimits",
    "retime",
]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
