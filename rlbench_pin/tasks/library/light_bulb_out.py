"""Take the bulb out of a lamp and stand it in the holder of the asked colour."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS, Detected, NothingGrasped, SpawnBoundary, Task, Waypoint, distractor_colors

LIT, UNLIT = (1.0, 0.91, 0.66), (1.0, 1.0, 1.0)
HANDS = {"waypoint1": np.pi, "waypoint4": 0.3735}
"""Yaw of the gripper that points down, about the vertical, at the waypoints that do not turn with the task [rad]."""


class LightBulbOut(Task):
    """The bulb must stand in the asked one of two holders, let go. It glows warm white while it is in the lamp.

    The colour of the asked holder varies, and the places and the colour of the two holders.
    """

    def init_task(self) -> None:
        """The bulb may be grasped; the gripper does not turn with the task."""
        self.holders = [self.world.body(f"holder{i}") for i in range(2)]
        self.bulb, self.sensor = self.world.body("bulb"), self.world.sensor("holder")
        self.in_lamp = Detected(self.bulb, self.world.sensor("lamp_socket"))
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(["bulb"])
        self.register_success_conditions([Detected(self.bulb, self.sensor), NothingGrasped(self.gripper)])
        self.register_waypoint_ability_start(0, self._turn_hands)

    def variation_count(self) -> int:
        """One for each colour of the asked holder."""
        return len(COLORS)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Colour and place the holders, and light the bulb; success is the bulb in the asked holder, let go."""
        goal = variation % 2
        name, rgb = COLORS[variation]
        self.holders[goal].set_color(rgb)
        self.holders[1 - goal].set_color(distractor_colors(rng, variation, 1)[0].rgb)
        self.boundary.scatter(self.holders, rng)
        for frame in (self.sensor, self.world.frame("waypoint4")):
            frame.set_parent(self.holders[goal].name)
        self.step()
        return self.make_instructions(color=name)

    def step(self) -> None:
        """Let the bulb glow while it stands in the lamp."""
        self.bulb.set_color(LIT if self.in_lamp.met() else UNLIT, "glass")

    def cleanup(self) -> None:
        """Light the bulb again."""
        self.bulb.set_color(LIT, "glass")

    def _turn_hands(self, waypoint: Waypoint) -> None:
        """Turn the gripper at the bulb and at the holder as in the world, after the task was placed."""
        for name, turn in HANDS.items():
            frame = self.world.frame(name)
            frame.set_pose([*frame.position, np.cos(turn / 2.0), np.sin(turn / 2.0), 0.0, 0.0])
