"""Put a folded umbrella into its stand."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, Task, Waypoint

ASIDE, PER_METRE = 1.3, -0.9
"""Angle between the level gripper at the stand and the direction away from the robot: at distance 0, and its growth per metre.

At an angle of 0 the wrist cannot bend far enough; far from the robot a large angle is out of reach. [rad], [rad/m].
"""


class PutUmbrellaInUmbrellaStand(Task):
    """The tip of the umbrella must be at the bottom of the stand, and the umbrella be released."""

    def init_task(self) -> None:
        """The umbrella may be grasped; success is its tip near the floor of the stand, and an empty gripper."""
        self.register_graspable_objects(["umbrella"])
        self.register_waypoint_ability_start(0, self._aim_away_from_robot)
        inside = Detected(self.world.frame("tip"), self.world.sensor("inside"))
        self.register_success_conditions([inside, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        self.register_rounds(1)  # so that a reset also aims before it checks the reach of the arm
        return self.make_instructions()

    def _aim_away_from_robot(self, waypoint: Waypoint) -> None:
        """Reach the round stand with a level gripper that points away from the robot and slightly to the side."""
        place = self.world.body("stand").position
        x, y = place[:2] - np.array(self.robot.description.base_pose[:2])
        half = (np.arctan2(y, x) + ASIDE + PER_METRE * np.hypot(x, y)) / 2.0
        self.world.frame("away").set_pose([*place, 0.0, 0.0, np.sin(half), np.cos(half)])
