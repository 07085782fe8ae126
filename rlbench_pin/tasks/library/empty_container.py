"""Move everything from a large tray into one of two small ones."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import (
    COLORS,
    BodySpec,
    Detected,
    SpawnBoundary,
    Task,
    Tray,
    Waypoint,
    clearance,
    distractor_colors,
    easiest_top_grasp,
    settle,
)

OBJECTS = ("object0", "object1", "object2")
SOLIDS, SIZES = 25, 40
"""Number of solids, and of sizes of each: a thousand shapes."""
DROP, APART = 0.2, 0.06
"""Start height of the lowest object above the tray, and the distance up to the next one [m]."""
PLACES = ((-0.04, -0.022), (0.04, -0.022), (0.0, 0.032))
"""Release places of the first, second and third object in the small tray: along it, and outwards from its middle [m]."""
ROOM = 0.045
"""A place is free at more than this distance from the middle of every other object [m]."""
INSIDE = np.array([0.165, 0.135])
"""Half size of the inside of the large tray [m]."""


class EmptyContainer(Task):
    """Three random objects must be in the small tray of the requested colour; they may still be held."""

    def init_task(self) -> None:
        """Aim again in every round; the rounds repeat until no object is left."""
        self.trays = [self.world.body("tray0"), self.world.body("tray1")]
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_waypoint_ability_start(0, self._aim_at_next_object)
        self.register_waypoint_ability_start(1, self._aim_at_next_object)
        self.register_waypoint_ability_start(3, self._aim_at_tray)
        self.register_waypoints_should_repeat(self._another_round)

    def variation_count(self) -> int:
        """One for each colour of the goal."""
        return len(COLORS)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Colour the trays and drop three objects, drawn from a thousand shapes, into the large tray."""
        name, rgb = COLORS[variation]
        goal = variation % 2
        self.trays[goal].set_color(rgb)
        self.trays[1 - goal].set_color(distractor_colors(rng, variation, 1)[0].rgb)
        self._drop_objects(rng)
        self.sensor = self.world.sensor(f"in_tray{goal}")
        self.left, self.round = list(OBJECTS), 0
        self.goal_side = 2 * goal - 1
        self._aim_at_tray()
        self.register_success_conditions([Detected(body, self.sensor) for body in self.objects])
        return self.make_instructions(color=name)

    def step(self) -> None:
        """Update the list of the objects that are not yet in the goal tray."""
        self.left[:] = [o for o in OBJECTS if not self.sensor.detects(o)]

    def _another_round(self) -> bool:
        """Count the rounds, so that a reset checks that all places are reachable; continue while an object is left."""
        self.round += 1
        return bool(self.left)

    def _drop_objects(self, rng: np.random.Generator) -> None:
        self.boundary.clear()
        for i, shape in enumerate(rng.choice(SOLIDS * SIZES, len(OBJECTS), replace=False)):
            solid, size = divmod(int(shape), SIZES)
            asset, pose = f"objects/convex/convex_{solid:02d}.urdf", (0.0, 0.0, DROP + APART * i, 0.0, 0.0, 0.0, 1.0)
            scale = 0.85 + 0.35 * size / SIZES
            spec = BodySpec(name=OBJECTS[i], asset=asset, pose=pose, scale=scale, role="manipulated")
            body = self.world.add_body(OBJECTS[i], spec)
            self.boundary.sample(body, rng, min_distance=0.0, ignore_collisions=True)
        self.objects = [self.world.body(name) for name in OBJECTS]
        self.register_graspable_objects(OBJECTS)
        settle(self.world, self.objects, rng)

    def _aim_at_next_object(self, waypoint: Waypoint) -> None:
        """Move above the object that is easiest to grasp, then down to it."""
        wanted = [self.world.body(name) for name in self.left or OBJECTS[:1]]
        grasp = easiest_top_grasp(wanted, self.objects, Tray(self.world.body("big_tray").pose, INSIDE))
        waypoint.frame.set_pose(grasp.tip_pose(waypoint.frame.position[2] if waypoint.index == 0 else None))

    def _aim_at_tray(self, waypoint: Waypoint | None = None) -> None:
        """Release objects beside those that are already in the tray, not onto them."""
        frame, first = self.world.frame("waypoint3"), min(self.round, len(PLACES) - 1)
        lying = [self.world.body(name) for name in OBJECTS if name not in self.left]
        for along, outwards in (*PLACES[first:], *PLACES[:first]):
            frame.set_local([along, self.goal_side * (0.25 + outwards), 0.17, 0.0, 1.0, 0.0, 0.0])
            if clearance(frame, lying) > ROOM:
                return
