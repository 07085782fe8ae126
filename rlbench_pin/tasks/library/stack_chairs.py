"""Stack two chairs on a third."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import (
    COLORS,
    NO_ROTATION,
    Aligned,
    Detected,
    NothingGrasped,
    SpawnBoundary,
    Task,
    Waypoint,
    distractor_colors,
)


class StackChairs(Task):
    """Two chairs must be stacked on the chair with the cushion of the requested colour, aligned with it, and be released.

    Either order counts. The colours and the places of the chairs vary.
    """

    def init_task(self) -> None:
        """All chairs may be grasped; each round puts the next one on the stack."""
        self.chairs = [self.world.body(name) for name in ("base", "chair0", "chair1")]
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(chair.name for chair in self.chairs)
        self.register_waypoint_ability_start(0, self._aim_at_next_chair)
        self.register_waypoint_ability_start(5, self._stay_after_last_chair)
        above = self.world.sensor("above_base")
        stacked = [Detected(self.world.frame(f"seat{i}"), above) for i in range(2)]
        aligned = Aligned(self.chairs[1:], self.chairs[0], 0.25)
        self.register_success_conditions([*stacked, aligned, NothingGrasped(self.gripper)])

    def variation_count(self) -> int:
        """One for each colour of the cushion of the lowest chair."""
        return len(COLORS)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Colour and place the chairs, all at the same yaw."""
        self.register_rounds(2)
        colors = [COLORS[variation], *distractor_colors(rng, variation, 2)]
        self.boundary.clear()
        for chair, color in zip(self.chairs, colors, strict=True):
            chair.set_color(color.rgb, "cushion")
        for chair in (*self.chairs[1:], self.chairs[0]):
            self.boundary.sample(chair, rng, min_rotation=NO_ROTATION, max_rotation=NO_ROTATION, min_distance=0.13)
        return self.make_instructions(color=colors[0].name)

    def _aim_at_next_chair(self, waypoint: Waypoint) -> None:
        """Aim at the chair of this round, and at the chair that was placed last."""
        self.world.frame("waypoint1").set_parent(f"chair{self.round}")
        self.world.frame("waypoint4").set_parent(("base", "chair0")[self.round])

    def _stay_after_last_chair(self, waypoint: Waypoint) -> None:
        waypoint.skip = self.round == 1
