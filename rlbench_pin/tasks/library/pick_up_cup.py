"""Pick up the cup of one colour."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS, Detected, Grasped, SpawnBoundary, Task, distractor_colors


class PickUpCup(Task):
    """The cup of the asked colour must be held, 5 cm above the table and clear of the zone where it stood.

    Another cup stands beside it.
    """

    def init_task(self) -> None:
        """Both cups may be grasped; success is that the asked one is held, is off the table and has left its zone."""
        self.cup, self.other = self.world.body("cup"), self.world.body("distractor")
        self.zone = self.world.sensor("start_zone")
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(["cup", "distractor"])
        off_table = Detected(self.cup, self.world.sensor("above_table"), negated=True)
        left = Detected(self.cup, self.zone, negated=True)
        self.register_success_conditions([Grasped(self.gripper, self.cup), off_table, left])

    def variation_count(self) -> int:
        """One for each colour of the cup."""
        return len(COLORS)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Colour and place both cups; the zone and the place on the rim to grip go with the asked one."""
        name, rgb = COLORS[variation]
        self.cup.set_color(rgb, "cup")
        self.other.set_color(distractor_colors(rng, variation, 1)[0].rgb, "cup")
        self.boundary.scatter([self.other, self.cup], rng, min_distance=0.1)
        x, y, z = self.cup.position
        self.zone.set_position([x, y, z + self.zone.size[1] / 2.0])
        self._aim_at_far_side_of_rim()
        return self.make_instructions(color=name)

    def _aim_at_far_side_of_rim(self) -> None:
        """Turn the frame of the approach, so that the outer finger has the other cup behind the asked one."""
        x, y, _ = self.cup.position - self.other.position
        frame, half = self.world.frame("rim"), np.arctan2(y, x) / 2.0
        frame.set_pose([*self.cup.position, 0.0, 0.0, np.sin(half), np.cos(half)])
