"""Changes of each episode of a runtime by its factors."""

from __future__ import annotations

import numpy as np

from rlbench_pin.environment.episode import EpisodeRandom
from rlbench_pin.environment.factors.catalogue import FactorSetting, factor_catalogue
from rlbench_pin.environment.factors.distractors import add_distractors
from rlbench_pin.environment.factors.draw import FIRST, OTHER, PLACES, draw_factors, other_instructions
from rlbench_pin.environment.observations.config import ObservationConfig
from rlbench_pin.environment.randomization.randomizer import WorldChanges
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.errors import InvalidArgument
from rlbench_pin.spatial import FloatArray

SHRINK = 0.7
"""Factor of the offsets of the start configuration after each attempt in which the arm touches a body."""
TRIES = 20
"""Maximum number of such reductions."""


class FactorRandomizer(WorldChanges):
    """Applies factors to each episode of one world.

    Args:
        runtime: Runtime of the world.
        config: Settings of its cameras and lights.
        setting: The factors and their levels.

    Raises:
        FactorNotApplicable: One of the factors does not apply to the task.
    """

    def __init__(self, runtime: Runtime, config: ObservationConfig, setting: FactorSetting) -> None:
        super().__init__(runtime)
        self._config, self.setting = config, setting
        if reason := setting.why_not(runtime.task):
            raise FactorNotApplicable(runtime.task.get_name(), str(setting), reason)
        self._factors = setting.for_task(runtime.task)
        self._other: tuple[str, ...] | None = None
        chosen = dict(setting.levels)
        self._draws_other = [name for name in chosen if factor_catalogue()[name].group == "language"] == [OTHER]
        """Whether the instructions are those of another variation; another factor of language replaces them."""
        self.accept = next((accept for name, accept in PLACES.items() if name in chosen), None)

    def prepare_episode(self, variation: int, seed: int, attempt: int) -> None:
        """Build the world with the bodies and the base pose of the arm for this episode.

        If `instruction_other` is set, also draw the instructions of another variation.
        """
        self.remove()
        first = FactorSetting(tuple((name, level) for name, level in self._factors.levels if name in FIRST))
        sample = draw_factors(self._runtime, self._config, first, seed, attempt)
        self._runtime.build_again(sample.sizes, sample.models)
        if self._draws_other:
            self._other = other_instructions(self._runtime, variation, seed, attempt)
            self._runtime.build_again(sample.sizes, sample.models)  # the physics of the episode does not depend on the draw
        self._runtime.place_arm(sample.base)

    def begin_episode(self, variation: int, random: EpisodeRandom, seed: int, attempt: int) -> None:
        """Change the world, the arm and the instructions at the start of an episode."""
        sample = draw_factors(self._runtime, self._config, self._factors, seed, attempt)
        if sample.distractors:
            add_distractors(self._runtime, sample.distractors, sample.distractor_seed)
        if sample.start is not None:
            self._start_at(sample.start)
        self.apply(sample)
        instructions = self._other if sample.instructions is None else sample.instructions
        if instructions is not None:
            self._runtime.instruct(instructions)

    def _start_at(self, offsets: FloatArray) -> None:
        """Put the arm at rest away from home; reduce the offset if it touches a body or violates a joint limit."""
        runtime, home = self._runtime, np.array(self._runtime.description.home)
        runtime.refresh_planner()
        for _ in range(TRIES):
            q = home + offsets
            if runtime.model.limits.contains(q) and not runtime.planner.collision.colliding_pairs(q):
                runtime.robot.reset_configuration(q)
                return
            offsets = SHRINK * offsets


class FactorNotApplicable(InvalidArgument):
    """A factor does not apply to a task."""

    def __init__(self, task: str, setting: str, reason: str) -> None:
        super().__init__(
            "factors", setting, f"cannot change '{task}': {reason}", "`rlbench-pin factors` lists the changes of each factor."
        )
