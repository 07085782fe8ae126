"""A scene whose looks and physics change."""

from __future__ import annotations

import numpy as np

from pyrep.pyrep import PyRep
from rlbench.backend.robot import Robot
from rlbench.backend.scene import Scene
from rlbench.backend.task import Task
from rlbench.observation_config import ObservationConfig
from rlbench.sim2real.domain_randomization import (
    DynamicsRandomizationConfig,
    RandomizeEvery,
    VisualRandomizationConfig,
)
from rlbench_pin.environment.randomization.randomizer import Randomizer


class DomainRandomizationScene(Scene):
    """A scene whose looks and physics change at the chosen events.

    Args:
        pyrep: The simulator.
        robot: Arm and gripper.
        obs_config: What observations contain.
        robot_setup: Name of the arm.
        randomize_every: The event.
        frequency: n: the first event and every n-th after it bring a new appearance.
        visual_randomization_config: What may change of the appearance, or None.
        dynamics_randomization_config: What may change of the physics, or None.
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
        """Build the world of a task in place of the present one, and tie the task to it."""
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
        """Go back to the empty table."""
        self._randomizer = None
        super().unload()

    def _before_episode(self) -> None:
        if self._randomizer is not None:
            self._randomizer.remove()

    def _after_episode_start(self, variation: int, rng: np.random.Generator) -> None:
        if self._randomizer is not None:
            self._randomizer.begin_episode(variation, rng)
