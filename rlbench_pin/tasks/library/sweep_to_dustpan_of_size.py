"""Sweep crumbs into the tall or the short dustpan; a variant of `sweep_to_dustpan`, not one of the paper's 106 tasks."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Task

CRUMBS = 5


class SweepToDustpanOfSize(Task):
    """All five crumbs must be in the requested dustpan. There is one dustpan on each side of them; the sides are random."""

    sizes = ("tall", "short")
    words = ("high", "low")

    def init_task(self) -> None:
        """The broom may be grasped."""
        self.pans = [self.world.body(f"{size}_pan") for size in self.sizes]
        self.crumbs = [self.world.body(f"crumb{i}") for i in range(CRUMBS)]
        self.register_graspable_objects(["broom"])

    def variation_count(self) -> int:
        """One for each dustpan."""
        return len(self.sizes)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Draw the sides of the pans and sweep towards the requested pan; success is every crumb in this pan."""
        places = rng.permutation([pan.pose for pan in self.pans])
        for pan, place in zip(self.pans, places, strict=True):
            pan.set_pose(place)
        side = np.sign(self.pans[variation].position[0] - self.world.root.position[0])
        for name in ("waypoint3", "waypoint5"):
            frame = self.world.frame(name)
            frame.set_local([side * frame.local[0], *frame.local[1:]])
        size, other, word = self.sizes[variation], self.sizes[1 - variation], self.words[variation]
        asked = self.world.sensor(f"in_{size}")
        self.register_success_conditions([Detected(crumb, asked) for crumb in self.crumbs])
        return self.make_instructions(size=size, other=other, walls=word)
