"""Put the lid on the jar of the requested colour."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS, Detected, NothingGrasped, SpawnBoundary, Task, distractor_colors


class CloseJar(Task):
    """The lid must be on the neck of the requested jar, and be released.

    The colour of the requested jar, the colour of the other jar, and the places of both vary. There is one lid.
    """

    def init_task(self) -> None:
        """The lid may be grasped; success is the lid around the neck of the goal on all sides, down on its rim."""
        self.jars = [self.world.body(f"jar{i}") for i in range(2)]
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(["lid"])
        lid, places = self.world.body("lid"), ("seat", "side0", "side1", "side2")
        seated = [Detected(lid, self.world.sensor(place)) for place in places]
        self.register_success_conditions([*seated, NothingGrasped(self.gripper)])

    def variation_count(self) -> int:
        """One for each colour of the requested jar."""
        return len(COLORS)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Colour and place the jars; move the goal to the requested jar."""
        goal = variation % 2
        name, rgb = COLORS[variation]
        self.jars[goal].set_color(rgb, "jar")
        self.jars[1 - goal].set_color(distractor_colors(rng, variation, 1)[0].rgb, "jar")
        self.boundary.scatter(self.jars, rng)
        self.world.frame("goal").set_parent(self.jars[goal].name)
        return self.make_instructions(color=name)
