"""Domain randomization: settings, and the scene that applies them.

Programs import `domain_randomization` and `domain_randomization_scene` from here; both are aliases of this module.
"""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

from pyrep.pyrep import PyRep
from rlbench.backend.robot import Robot
from rlbench.backend.scene import Scene
from rlbench.backend.task import Task
from rlbench.observation_config import ObservationConfig
from rlbench_pin.compat import add_aliases
from rlbench_pin.compat.objects.elements import ROOM_NAMES, robot_names
from rlbench_pin.environment.randomization import DynamicsRandomizationConfig, RandomizeEvery
from rlbench_pin.environment.randomization import VisualRandomizationConfig as NativeVisualRandomizationConfig
from rlbench_pin.environment.randomization.config import RandomizationConfig
from rlbench_pin.environment.randomization.randomizer import Randomizer
from rlbench_pin.robot.description import SUPPORTED_ROBOTS

__all__ = [
    "Distributions",
    "DomainRandomizationScene",
    "DynamicsRandomizationConfig",
    "Gaussian",
    "RandomizationConfig",
    "RandomizeEvery",
    "Uniform",
    "VisualRandomizationConfig",
]


class VisualRandomizationConfig(NativeVisualRandomizationConfig):
    """Random textures of task, robot and room; see `rlbench_pin.VisualRandomizationConfig`.

    Whitelist and blacklist may contain the names of parts of the room from RLBench (`Floor`, `Wall1`, `diningTable_visible`) or
    from our scenes (`floor`, `table`).
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
        """Return whether the object with a name may change."""
        known = ROOM_NAMES.get(name, robot_names(SUPPORTED_ROBOTS[name]).arm if name in SUPPORTED_ROBOTS else name)
        listed = None if self.whitelist is None else _matches(name, self.whitelist) or _matches(known, self.whitelist)
        return listed is not False and not _matches(name, self.blacklist) and not _matches(known, self.blacklist)


def _matches(name: str, patterns: Sequence[str] | None) -> bool:
    """Return whether a name matches one of some patterns with `*` and `?`; None is no pattern."""
    return any(fnmatchcase(name, pattern) for pattern in patterns or ())


class Distributions:
    """Base class of distributions of random numbers."""

    def apply(self, val: np.ndarray) -> np.ndarray:
        """Return `val` with random numbers added."""
        raise NotImplementedError(f"{type(self).__name__} has no `apply(val)`. Override it.")


class Gaussian(Distributions):
    """A normal distribution around zero.

    Args:
        variance: Standard deviation; RLBench uses this name.
    """

    def __init__(self, variance: float) -> None:
        self._variance = variance

    def apply(self, val: np.ndarray) -> np.ndarray:
        """Return `val` with random numbers added."""
        return np.asarray(val) + np.random.normal(0.0, self._variance, np.shape(val))


class Uniform(Distributions):
    """A uniform distribution.

    Args:
        min: Lower bound.
        max: Upper bound.
    """

    def __init__(self, min: float, max: float) -> None:
        self._min, self._max = min, max

    def apply(self, val: np.ndarray) -> np.ndarray:
        """Return `val` with random numbers added."""
        return np.asarray(val) + np.random.uniform(self._min, self._max, np.shape(val))


class DomainRandomizationScene(Scene):
    """A scene whose appearance and physics change at the chosen events.

    Args:
        pyrep: The simulator.
        robot: Arm and gripper.
        obs_config: Contents of observations.
        robot_setup: Name of the arm.
        randomize_every: Event that starts a new randomization.
        frequency: Randomize at every n-th event, from the first on.
        visual_randomization_config: Settings of the appearance, or None.
        dynamics_randomization_config: Settings of the physics, or None.
    """

    def __init__(
        self,
        pyrep: PyRep,
        robot: Robot,
        obs_config: ObservationConfig | None = None,
        robot_setup: str = "panda",
        randomize_every: RandomizeEvery | None = RandomizeEvery.EPISODE,
        frequency: int = 1,
        visual_randomization_config: VisualRandomizationConfig | None = None,
        dynamics_randomization_config: DynamicsRandomizationConfig | None = None,
    ) -> None:
        self._randomize_every = RandomizeEvery.EPISODE if randomize_every is None else randomize_every
        self._frequency = frequency
        self._visual_rand_config = visual_randomization_config
        self._dynamics_rand_config = dynamics_randomization_config
        self._randomizer: Randomizer | None = None
        super().__init__(pyrep, robot, obs_config, robot_setup)

    def load(self, task: Task) -> None:
        """Build the world of a task, replace the current world by it, and connect the task to it."""
        super().load(task)
        self._randomizer = Randomizer(
            self.runtime,
            self._obs_config,
            self._randomize_every,
            self._frequency,
            self._visual_rand_config,
            self._dynamics_rand_config,
        )

    def unload(self) -> None:
        """Replace the world of the task by the empty table."""
        self._randomizer = None
        super().unload()

    def _before_episode(self) -> None:
        if self._randomizer is not None:
            self._randomizer.remove()

    def _after_episode_start(self, variation: int, rng: np.random.Generator) -> None:
        if self._randomizer is not None:
            self._randomizer.randomize(variation, rng)


add_aliases(__name__, ("domain_randomization", "domain_randomization_scene"))
