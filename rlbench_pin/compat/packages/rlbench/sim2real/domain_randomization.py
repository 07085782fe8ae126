"""Domain randomization: when it happens and what may change."""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

from rlbench_pin.compat.things.names import ROOM_NAMES
from rlbench_pin.environment.randomization import DynamicsRandomizationConfig, RandomizeEvery
from rlbench_pin.environment.randomization import VisualRandomizationConfig as NativeVisualRandomizationConfig
from rlbench_pin.environment.randomization.config import RandomizationConfig
from rlbench_pin.robot.description import SUPPORTED_ROBOTS


class VisualRandomizationConfig(NativeVisualRandomizationConfig):
    """Textures of task, robot and room; see `rlbench_pin.VisualRandomizationConfig`.

    White and black list may name parts of the room as programs know them (`Floor`, `Wall1`, `diningTable_visible`) or as our
    scenes do (`floor`, `table`).
    """

    def __init__(
        self,
        image_directory: str | Path | None = None,
        whitelist: Sequence[str] | None = None,
        blacklist: Sequence[str] | None = None,
        randomize_arm: bool = True,
    ) -> None:
        super().__init__(image_directory, whitelist, blacklist, randomize_arm, light=0.0)

    def should_randomize(self, name: str) -> bool:
        """Whether the thing called `name` may change."""
        known = ROOM_NAMES.get(name, name.capitalize() if name in SUPPORTED_ROBOTS else name)
        listed = None if self.whitelist is None else _matches(name, self.whitelist) or _matches(known, self.whitelist)
        return listed is not False and not _matches(name, self.blacklist) and not _matches(known, self.blacklist)


def _matches(name: str, patterns: Sequence[str] | None) -> bool:
    return any(fnmatchcase(name, pattern) for pattern in patterns or ())


class Distributions:
    """What numbers are drawn from."""

    def apply(self, val: np.ndarray) -> np.ndarray:
        """Return `val` with a draw added."""
        raise NotImplementedError(f"{type(self).__name__} has no `apply(val)`. Override it.")


class Gaussian(Distributions):
    """A normal distribution around zero.

    Args:
        variance: Standard deviation; the name is the one existing programs use.
    """

    def __init__(self, variance: float) -> None:
        self._variance = variance

    def apply(self, val: np.ndarray) -> np.ndarray:
        """Return `val` with a draw added."""
        return np.asarray(val) + np.random.normal(0.0, self._variance, np.shape(val))


class Uniform(Distributions):
    """A uniform distribution.

    Args:
        min: Lowest number.
        max: Highest number.
    """

    def __init__(self, min: float, max: float) -> None:
        self._min, self._max = min, max

    def apply(self, val: np.ndarray) -> np.ndarray:
        """Return `val` with a draw added."""
        return np.asarray(val) + np.random.uniform(self._min, self._max, np.shape(val))


__all__ = [
    "Distributions",
    "DynamicsRandomizationConfig",
    "Gaussian",
    "RandomizationConfig",
    "RandomizeEvery",
    "Uniform",
    "VisualRandomizationConfig",
]
