"""Take the lid off the jar of the requested colour."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS, Detected, NothingGrasped, SpawnBoundary, Task, distractor_colors


class OpenJar(Task):
    """The lid of the requested jar must be inside a ring on the table, and be released.

    The colour of the requested jar, the colour of the other jar, and the places of both vary. Each jar has a lid.
    """

    def init_task(self) -> None:
        """Both lids may be grasped."""
        self.jars = [self.world.body(f"jar{i}") for i in range(2)]
        self.lids = [self.world.body(f"lid{i}") for i in range(2)]
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(lid.name for lid in self.lids)

    def variation_count(self) -> int:
        """One for each colour of the requested jar."""
        return len(COLORS)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Colour and place the jars; success is the requested lid inside the ring, and an empty gripper."""
        goal = variation % 2
        name, rgb = COLORS[variation]
        self.jars[goal].set_color(rgb, "jar")
        self.jars[1 - goal].set_color(distractor_colors(rng, variation, 1)[0].rgb, "jar")
        self.boundary.scatter(self.jars, rng)
        self.world.frame("goal").set_parent(self.jars[goal].name)
        on_table = Detected(self.lids[goal], self.world.sensor("table_spot"))
        self.register_success_conditions([on_table, NothingGrasped(self.gripper)])
        return self.make_instructions(color=name)
