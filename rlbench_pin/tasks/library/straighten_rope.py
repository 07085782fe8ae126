"""Pull a rope straight."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Task

GREEN, LIT = (0.05, 0.50, 0.18), (0.15, 1.0, 0.25)


class StraightenRope(Task):
    """Both ends of the rope must lie on their marks, which are nearly the length of the rope apart.

    A mark shines while its end lies on it.
    """

    def init_task(self) -> None:
        """Success is each end of the rope on its mark."""
        self.head = Detected(self.world.frame("head"), self.world.sensor("at_head_mark"))
        self.tail = Detected(self.world.frame("tail"), self.world.sensor("at_tail_mark"))
        self.register_success_conditions([self.head, self.tail])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Begin with dull marks; only the place of the task varies."""
        self.step()
        return [
            "Lay each end of the rope on the green ring nearer to it.",
            "The rope is bent: pull its ends apart, each to the green ring that is closer.",
            "Stretch the rope out so that each green ring has the nearer end in it.",
        ]

    def step(self) -> None:
        """Let each mark show whether its end lies on it."""
        for end, mark in ((self.head, "head_mark"), (self.tail, "tail_mark")):
            self.world.body(mark).set_color(LIT if end.met() else GREEN)
