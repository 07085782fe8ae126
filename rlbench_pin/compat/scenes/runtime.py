"""The runtime behind a scene: what steps it and looks at it goes through the scene, so that subclasses of the scene are asked."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.errors import InvalidActionError
from rlbench_pin.observation import Observation
from rlbench_pin.spatial import FloatArray


class Stage(Protocol):
    """What a runtime asks its scene for."""

    def step(self) -> None:
        """Advance one control tick."""
        ...

    def get_observation(self) -> Observation:
        """Observe without stepping."""
        ...

    def check_target_in_workspace(self, pos: FloatArray) -> bool:
        """Whether a target (3,) [m] may be reached for."""
        ...

    def prepare(self) -> None:
        """Called when an episode is about to be laid out and the world is as it was built."""
        ...

    def place(self, rng: np.random.Generator) -> None:
        """Put the task at a random place on the table, drawn from `rng`."""
        ...


class SceneRuntime(Runtime):
    """A runtime that serves one scene. Native code and programs thus run through the same methods of the scene."""

    _stage: Stage | None = None

    def serve(self, stage: Stage) -> None:
        """Go through `stage` from now on."""
        self._stage = stage

    def step(self) -> None:
        """Advance one control tick, through the scene."""
        if self._stage is None:
            self.advance()
        else:
            self._stage.step()

    def advance(self) -> None:
        """Advance one control tick: physics, then the task's own step, then the callbacks."""
        super().step()

    def begin(self, variation: int, planning: np.random.Generator, noise: np.random.Generator) -> None:
        """Take over what an episode is given, and let the scene prepare it."""
        super().begin(variation, planning, noise)
        if self._stage is not None:
            self._stage.prepare()

    def place_task(self, rng: np.random.Generator) -> None:
        """Put the task at a random place on the table, through the scene."""
        if self._stage is None:
            super().place_task(rng)
        else:
            self._stage.place(rng)

    def get_observation(self) -> Observation:
        """Observe without stepping, through the scene."""
        return self.observe() if self._stage is None else self._stage.get_observation()

    def observe(self) -> Observation:
        """Observe without stepping."""
        return super().get_observation()

    def check_target_in_workspace(self, position: FloatArray) -> None:
        """Raise InvalidActionError when the scene says that `position` (3,) [m] is outside the workspace."""
        if self._stage is None or not self._stage.check_target_in_workspace(position):
            super().check_target_in_workspace(position)
        if self._stage is not None and not self._stage.check_target_in_workspace(position):
            x, y, z = position
            raise InvalidActionError(
                f"The target ({x:.4f}, {y:.4f}, {z:.4f}) m is outside the workspace of the scene. Choose a target inside."
            )
