"""Turn the left-most knob of an oven."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task


class TurnOvenOn(Task):
    """The left-most of six knobs must turn by more than 1.5 rad; the others are fixed."""

    solved_by_chance = True  # a blow can turn the knob

    def init_task(self) -> None:
        """Success is a turn of the knob by more than 1.5 rad."""
        self.register_success_conditions([JointMoved(self.world.joint("oven/knob"), 1.5)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the sentences; only the place of the task varies."""
        return [
            "Turn the leftmost knob of the oven by a good quarter turn.",
            "The oven is cold: switch it on with the knob on the far left.",
            "I want to bake, so rotate the first knob from the left to its side.",
        ]
