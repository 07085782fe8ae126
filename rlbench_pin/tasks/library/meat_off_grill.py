"""Take one of two pieces of meat off a grill."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import AnyOf, Detected, NothingGrasped, Task


class MeatOffGrill(Task):
    """The requested piece of meat must be on the table beside a long side of the grill, and be released."""

    meats = ("chicken", "steak")

    solved_by_chance = True

    def init_task(self) -> None:
        """Both pieces of meat may be grasped."""
        self.sides = [self.world.sensor(name) for name in ("side", "far_side")]
        self.register_graspable_objects(self.meats)

    def variation_count(self) -> int:
        """One for each piece of meat."""
        return len(self.meats)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Aim at the requested meat; success is the meat beside the grill, and an empty gripper."""
        meat = self.world.body(self.meats[variation])
        grasp = self.world.frame("waypoint1")
        grasp.set_position([*meat.position[:2], grasp.position[2]])
        beside = AnyOf([Detected(meat, side) for side in self.sides])
        self.register_success_conditions([NothingGrasped(self.gripper), beside])
        return self.make_instructions(meat=meat.name)
