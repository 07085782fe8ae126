"""Hang mugs on a mug tree."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import AllOf, AnyOf, Detected, NothingGrasped, SpawnBoundary, Task, Waypoint

NUMBER = ("one mug", "two mugs", "three mugs")


class PlaceCups(Task):
    """One, two or three of three identical mugs must hang by their handles on any of four spokes; any mug counts."""

    def init_task(self) -> None:
        """All mugs may be grasped; each round aims at the next one."""
        self.mugs = [self.world.body(f"mug{i}") for i in range(3)]
        self.sensors = [self.world.sensor(f"under_spoke{k}") for k in range(4)]
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(f"mug{i}" for i in range(3))
        self.register_waypoint_ability_start(0, self._aim_at_next_mug)
        self.register_waypoints_should_repeat(lambda: self.next < self.wanted)

    def variation_count(self) -> int:
        """One for each number of mugs."""
        return len(NUMBER)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Place the mugs; success is that the requested number hangs on any spokes, and an empty gripper."""
        self.next, self.wanted = 0, variation + 1
        self.boundary.scatter(self.mugs, rng, min_distance=0.1)
        hung = [AnyOf([Detected(mug, sensor) for sensor in self.sensors]) for mug in self.mugs]
        all_but_one = [AllOf([hung[i] for i in range(3) if i != left]) for left in range(3)]
        enough = (AnyOf(hung), AnyOf(all_but_one), AllOf(hung))[variation]
        self.register_success_conditions([enough, NothingGrasped(self.gripper)])
        them, dangle = ("it", "dangles") if self.wanted == 1 else ("them", "dangle")
        return self.make_instructions(mugs=NUMBER[variation], them=them, dangle=dangle)

    def _aim_at_next_mug(self, waypoint: Waypoint) -> None:
        """Aim at the next mug, with the same grasp, and at the next spoke."""
        self.world.frame("waypoint1").set_parent(f"mug{self.next}")
        self.world.frame("waypoint4").set_parent(f"spoke{self.next}")
        self.next += 1
