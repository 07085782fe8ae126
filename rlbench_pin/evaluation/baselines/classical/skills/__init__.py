"""What the hand can do, independent of what it is done to."""

from __future__ import annotations

from rlbench_pin.evaluation.baselines.classical.skills.actions import arc, pick, place, press, pull, sweep, touch
from rlbench_pin.evaluation.baselines.classical.skills.driver import Driver
from rlbench_pin.evaluation.baselines.classical.skills.hand import Hand, Moves, Tick, Way
from rlbench_pin.evaluation.baselines.classical.skills.poses import (
    DOWN,
    PAD,
    all_down,
    both_ways,
    down,
    placed,
    pointing,
    sloping,
)

__all__ = [
    "DOWN",
    "PAD",
    "Driver",
    "Hand",
    "Moves",
    "Tick",
    "Way",
    "all_down",
    "arc",
    "both_ways",
    "down",
    "pick",
    "place",
    "placed",
    "pointing",
    "press",
    "pull",
    "sloping",
    "sweep",
    "touch",
]
