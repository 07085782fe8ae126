"""Put the bulb from the holder of the requested colour into a lamp."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS, Detected, NothingGrasped, SpawnBoundary, Task, distractor_colors

LIT, UNLIT = (1.0, 0.91, 0.66), (1.0, 1.0, 1.0)


class LightBulbIn(Task):
    """The bulb of the requested holder must be in the socket of the lamp, and be released; in the socket it lights up.

    The colour of the requested holder, the colour of the other holder, and the places of both vary. Each contains a bulb.
    """

    def init_task(self) -> None:
        """Both bulbs may be grasped."""
        self.holders = [self.world.body(f"holder{i}") for i in range(2)]
        self.bulbs = [self.world.body(f"bulb{i}") for i in range(2)]
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(bulb.name for bulb in self.bulbs)

    def variation_count(self) -> int:
        """One for each colour of the requested holder."""
        return len(COLORS)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Colour and place the holders; success is the requested bulb in the socket, and an empty gripper."""
        goal = variation % 2
        name, rgb = COLORS[variation]
        self.holders[goal].set_color(rgb)
        self.holders[1 - goal].set_color(distractor_colors(rng, variation, 1)[0].rgb)
        self.boundary.scatter(self.holders, rng)
        self.bulb = self.bulbs[goal]
        self.world.frame("waypoint1").set_parent(self.bulb.name)
        self.in_socket = Detected(self.bulb, self.world.sensor("socket"))
        self.register_success_conditions([self.in_socket, NothingGrasped(self.gripper)])
        return self.make_instructions(color=name)

    def step(self) -> None:
        """Light the requested bulb while it is in the socket."""
        self.bulb.set_color(LIT if self.in_socket.met() else UNLIT, "glass")

    def cleanup(self) -> None:
        """Switch both bulbs off."""
        for bulb in self.bulbs:
            bulb.set_color(UNLIT, "glass")
