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
"""A thousand shapes: so many solids in so many sizes."""
DROP, APART = 0.2, 0.06
"""Height of the lowest object over the tray, and how much higher the next one starts [m]."""
PLACES = ((-0.04, -0.022), (0.04, -0.022), (0.0, 0.032))
"""Where the first, second and third object are let go in the small tray: along it, and outwards from its middle [m]."""
ROOM = 0.045
"""How far from the middle of another object a place is free [m]."""
INSIDE = np.array([0.165, 0.135])
"""Half size of the inside of the large tray [m]."""


class EmptyContainer(Task):
    """Three random objects must lie in the small tray of the asked colour."""

    def init_task(self) -> None:
        """Aim anew in every round; there are as many as it takes."""
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
        """Colour the trays and drop three objects, drawn from a thousand, into the large one."""
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
        """Note which objects still have to be moved."""
        self.left[:] = [o for o in OBJECTS if not self.sensor.detects(o)]

    def _another_round(self) -> bool:
        """Count the rounds, so that a reset sees that all places can be reached; go on while something is left."""
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
        """Go over, then down to the object that is easiest to grip."""
        wanted = [self.world.body(name) for name in self.left or OBJECTS[:1]]
        grasp = easiest_top_grasp(wanted, self.objects, Tray(self.world.body("big_tray").pose, INSIDE))
        waypoint.frame.set_pose(grasp.tip_pose(waypoint.frame.position[2] if waypoint.index == 0 else None))

    def _aim_at_tray(self, waypoint: Waypoint | None = None) -> None:
        """Let things go beside those that lie in the tray already, not onto them."""
        frame, first = self.world.frame("waypoint3"), min(self.round, len(PLACES) - 1)
        lying = [self.world.body(name) for name in OBJECTS if name not in self.left]
        for along, outwards in (*PLACES[first:], *PLACES[:first]):
            frame.set_local([along, self.goal_side * (0.25 + outwards), 0.17, 0.0, 1.0, 0.0, 0.0])
            if clearance(frame, lying) > ROOM:
                return
