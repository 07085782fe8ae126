"""Nest two cups in a third."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import (
    COLORS,
    NO_ROTATION,
    Detected,
    NothingGrasped,
    SpawnBoundary,
    Task,
    Waypoint,
    distractor_colors,
    free_direction,
)

HEADINGS = np.arange(16) * np.pi / 8.0
"""Directions from the finger outside a cup to the one inside, best first [rad]."""
LANE, LENGTH = 0.06, 0.185
"""Half width and length of the space for the gripper beside a cup; no middle of another cup may be in it [m]."""


class StackCups(Task):
    """Two cups must be nested upright in the cup of the requested colour, in either order, and be released."""

    def init_task(self) -> None:
        """All cups may be grasped; each round puts the next one on the stack."""
        self.cups = [self.world.body(name) for name in ("base", "cup0", "cup1")]
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(cup.name for cup in self.cups)
        self.register_waypoint_ability_start(0, self._aim_at_next_cup)
        self.register_waypoint_ability_start(5, self._stay_after_last_cup)
        ends = (("foot", self.world.sensor("in_base")), ("mouth", self.world.sensor("over_base")))
        nested = [Detected(self.world.frame(f"{end}{i}"), sensor) for i in range(2) for end, sensor in ends]
        self.register_success_conditions([*nested, NothingGrasped(self.gripper)])

    def variation_count(self) -> int:
        """One for each colour of the cup that stays."""
        return len(COLORS)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Colour and place the cups, and find a free side of each cup."""
        self.register_rounds(2)
        name, rgb = COLORS[variation]
        self.boundary.clear()
        for cup in self.cups:
            cup.set_color(rgb if cup is self.cups[0] else distractor_colors(rng, variation, 1)[0].rgb, "cup")
            self.boundary.sample(cup, rng, min_rotation=NO_ROTATION, max_rotation=NO_ROTATION, min_distance=0.05)
        for i in range(3):
            self._find_free_side(i)
        return self.make_instructions(name=name)

    def _find_free_side(self, number: int) -> None:
        """Turn the frame on a cup so that its x points to a side without another cup."""
        places = [cup.position[:2] for cup in self.cups]
        heading = free_direction(places[number], HEADINGS, places, LANE, LENGTH) or 0.0
        frame, half = self.world.frame(f"side{number}"), (heading + np.pi) / 2.0
        frame.set_pose([*frame.position, 0.0, 0.0, np.sin(half), np.cos(half)])

    def _aim_at_next_cup(self, waypoint: Waypoint) -> None:
        """Aim at the cup of this round, and at the next place in the base."""
        self.world.frame("waypoint1").set_parent(f"side{self.round + 1}")
        self.world.frame("waypoint4").set_parent(f"nest{self.round}")

    def _stay_after_last_cup(self, waypoint: Waypoint) -> None:
        waypoint.skip = self.round == 1
