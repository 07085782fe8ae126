"""What the hand can do, independent of what it is done to."""

from __future__ import annotations

from rlbench_pin.evaluation.baselines.classical.skills.actions import arc, pick, place, press, sweep, touch
from rlbench_pin.evaluation.baselines.classical.skills.hand import Hand, Move, Moves
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
    "Hand",
    "Move",
    "Moves",
    "all_down",
    "arc",
    "both_ways",
    "down",
    "pick",
    "place",
    "placed",
    "pointing",
    "press",
    "sloping",
    "sweep",
    "touch",
]
