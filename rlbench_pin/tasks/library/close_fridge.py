"""Shut the upper door of a fridge."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task


class MovedTowardsShut(JointMoved):
    """As `JointMoved`, and the joint is nearer to 0 than at the start."""

    def met(self) -> bool:
        """Return whether the joint is far enough from its start now, towards 0."""
        return super().met() and self.joint.position < self.start


class CloseFridge(Task):
    """The upper door stands open and must swing by 30 degrees towards the body; opening it further is nothing."""

    solved_by_chance = True

    def init_task(self) -> None:
        """Success is a turn of the upper door by 30 degrees, inwards."""
        self.register_success_conditions([MovedTowardsShut(self.world.joint("fridge/upper_door"), np.deg2rad(30.0))])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the sentences; only the place of the task varies."""
        return [
            "Push the open door of the refrigerator shut.",
            "The fridge is losing its cold, so close it.",
            "Before the milk gets warm, swing the upper door back to its frame.",
        ]
