"""Domain randomization of looks and dynamics: settings, samples, and the events that bring new ones."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.environment.randomization.config import (
    DynamicsRandomizationConfig,
    NoTextureFolder,
    NoTextures,
    RandomizationConfig,
    RandomizationMisused,
    RandomizeEvery,
    VisualRandomizationConfig,
)
from rlbench_pin.environment.randomization.randomizer import Randomizer
from rlbench_pin.environment.randomization.sample import RandomizationSample
from rlbench_pin.front_door import front_door

__all__ = [
    "DynamicsRandomizationConfig",
    "NoTextureFolder",
    "NoTextures",
    "RandomizationConfig",
    "RandomizationMisused",
    "RandomizationSample",
    "RandomizeEvery",
    "Randomizer",
    "VisualRandomizationConfig",
]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
