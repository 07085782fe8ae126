"""Put a square ring over the pillar of the requested colour."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS, Detected, SpawnBoundary, Task, distractor_colors


class InsertOntoSquarePeg(Task):
    """The ring must be around the foot of the pillar of the requested colour, one of three.

    The requested pillar, the colours of the other two and the place of the ring vary.
    """

    def init_task(self) -> None:
        """The ring may be grasped; success is the ring on all four sides of the goal."""
        self.ring = self.world.body("ring")
        self.pillars = [self.world.body(f"pillar{i}") for i in range(3)]
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(["ring"])
        sides = [Detected(self.ring, self.world.sensor(f"side{i}")) for i in range(4)]
        self.register_success_conditions(sides)

    def variation_count(self) -> int:
        """One for each colour of the goal."""
        return len(COLORS)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Draw which pillar is the goal, colour all three, and place the ring."""
        name, rgb = COLORS[variation]
        goal, *others = (self.pillars[i] for i in rng.permutation(3))
        goal.set_color(rgb)
        for pillar, color in zip(others, distractor_colors(rng, variation, 2), strict=True):
            pillar.set_color(color.rgb)
        self.world.frame("goal").move_to(goal.name)
        self.boundary.scatter([self.ring], rng)
        return self.make_instructions(color=name)
