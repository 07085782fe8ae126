"""Pick up the cup of the requested colour."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS, Detected, Grasped, SpawnBoundary, Task, distractor_colors


class PickUpCup(Task):
    """The gripper must hold the cup of the requested colour more than 5 cm above the table and outside its start zone.

    There is a second cup of another colour.
    """

    def init_task(self) -> None:
        """Both cups may be grasped; success is the requested cup in the gripper, above the table and outside its start zone."""
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
        """Colour and place both cups; move the zone and the grasp on the rim to the requested cup."""
        name, rgb = COLORS[variation]
        self.cup.set_color(rgb, "cup")
        self.other.set_color(distractor_colors(rng, variation, 1)[0].rgb, "cup")
        self.boundary.scatter([self.other, self.cup], rng, min_distance=0.1)
        x, y, z = self.cup.position
        self.zone.set_position([x, y, z + self.zone.size[1] / 2.0])
        self._aim_at_far_side_of_rim()
        return self.make_instructions(color=name)

    def _aim_at_far_side_of_rim(self) -> None:
        """Turn the approach frame to the side of the requested cup that is opposite to the other cup."""
        x, y, _ = self.cup.position - self.other.position
        frame, half = self.world.frame("rim"), np.arctan2(y, x) / 2.0
        frame.set_pose([*self.cup.position, 0.0, 0.0, np.sin(half), np.cos(half)])
