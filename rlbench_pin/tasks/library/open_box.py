"""Fold up the lid of a carton."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task


class OpenBox(Task):
    """The lid must turn past upright, by more than 90 degrees."""

    def init_task(self) -> None:
        self.register_success_conditions([JointMoved(self.world.joint("carton/lid_hinge"), np.pi / 2.0)])

    def variation_count(self) -> int:
        return 1

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        return [
            "Flip the lid of the carton up.",
            "Take the cardboard box by the edge of its cover and open it.",
            "I want to look into the carton, lift its lid.",
        ]
