"""Domain randomization of appearance and dynamics: settings, samples, and the events of new samples."""

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
