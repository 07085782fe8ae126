"""Take the bulb out of a lamp and put it into the holder of the requested colour."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS, Detected, NothingGrasped, SpawnBoundary, Task, Waypoint, distractor_colors

LIT, UNLIT = (1.0, 0.91, 0.66), (1.0, 1.0, 1.0)
HANDS = {"waypoint1": np.pi, "waypoint4": 0.3735}
"""World yaw of the downward gripper at the waypoints whose yaw does not follow the task [rad]."""


class LightBulbOut(Task):
    """The bulb must be in the requested one of two holders, and be released. It is lit while it is in the lamp.

    The colour of the requested holder, the colour of the other holder, and the places of both vary.
    """

    def init_task(self) -> None:
        """The bulb may be grasped; the yaw of the gripper does not follow the yaw of the task."""
        self.holders = [self.world.body(f"holder{i}") for i in range(2)]
        self.bulb, self.sensor = self.world.body("bulb"), self.world.sensor("holder")
        self.in_lamp = Detected(self.bulb, self.world.sensor("lamp_socket"))
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(["bulb"])
        self.register_success_conditions([Detected(self.bulb, self.sensor), NothingGrasped(self.gripper)])
        self.register_waypoint_ability_start(0, self._turn_hands)

    def variation_count(self) -> int:
        """One for each colour of the requested holder."""
        return len(COLORS)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Colour and place the holders, and light the bulb; success is the bulb in the requested holder, and an empty gripper."""
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
        """Light the bulb while it is in the lamp."""
        self.bulb.set_color(LIT if self.in_lamp.met() else UNLIT, "glass")

    def cleanup(self) -> None:
        """Light the bulb again."""
        self.bulb.set_color(LIT, "glass")

    def _turn_hands(self, waypoint: Waypoint) -> None:
        """Set the yaw of the gripper at the bulb and at the holder in world coordinates, after the placement of the task."""
        for name, turn in HANDS.items():
            frame = self.world.frame(name)
            frame.set_pose([*frame.position, np.cos(turn / 2.0), np.sin(turn / 2.0), 0.0, 0.0])
