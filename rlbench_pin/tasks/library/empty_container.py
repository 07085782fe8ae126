"""Move everything from a large tray into one of two small ones."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS, BodySpec, Detected, SpawnBoundary, Task, Waypoint, distractor_colors

OBJECTS = ("object0", "object1", "object2")
SOLIDS, SIZES = 25, 40
"""A thousand shapes: so many solids in so many sizes."""
DROP, APART = 0.2, 0.06
"""Height of the lowest object over the tray, and how much higher the next one starts [m]."""
FALL = 20
"""Control ticks until the objects have come to rest."""
INSIDE = np.array([0.125, 0.095])
"""Half size of the inside of the large tray [m]."""
FINGER, PAD = 0.052, 0.008
"""How far an open finger reaches from the middle of the hand, and half its breadth [m]."""


class EmptyContainer(Task):
    """Three random objects must lie in the small tray of the asked colour."""

    def init_task(self) -> None:
        self.trays = [self.scene.body("tray0"), self.scene.body("tray1")]
        self.boundary = SpawnBoundary([self.scene.region("patch")])
        self.register_waypoint_ability_start(1, self._aim_at_next_object)
        self.register_waypoints_should_repeat(lambda: bool(self.left))

    def variation_count(self) -> int:
        return len(COLORS)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        name, rgb = COLORS[variation]
        goal = variation % 2
        self.trays[goal].set_color(rgb)
        self.trays[1 - goal].set_color(distractor_colors(rng, variation, 1)[0].rgb)
        self._create_objects(rng)
        self.sensor = self.scene.sensor(f"in_tray{goal}")
        self.left = list(OBJECTS)
        self.scene.frame("waypoint3").set_local([0.0, 0.25 * (2 * goal - 1), 0.17, 1.0, 0.0, 0.0, 0.0])
        self.register_success_conditions([Detected(self.scene.body(o), self.sensor) for o in OBJECTS])
        return [
            f"Put everything from the large tray into the {name} one.",
            f"The three things in the middle belong in the {name} tray.",
            f"Empty the big container into the small {name} container.",
        ]

    def step(self) -> None:
        self.left[:] = [o for o in OBJECTS if not self.sensor.detects(o)]

    def cleanup(self) -> None:
        for name in OBJECTS:
            self.scene.remove_body(name)

    def _create_objects(self, rng: np.random.Generator) -> None:
        self.boundary.clear()
        for i, shape in enumerate(rng.choice(SOLIDS * SIZES, len(OBJECTS), replace=False)):
            solid, size = divmod(int(shape), SIZES)
            asset = f"objects/convex/convex_{solid:02d}.urdf"
            spec = BodySpec(
                name=OBJECTS[i],
                asset=asset,
                pose=(0.0, 0.0, DROP + APART * i, 0.0, 0.0, 0.0, 1.0),
                scale=0.85 + 0.35 * size / SIZES,
            )
            body = self.scene.add_body(OBJECTS[i], spec)
            self.boundary.sample(body, rng, min_distance=0.0, ignore_collisions=True)
        self.register_graspable_objects(OBJECTS)
        for _ in range(FALL):
            self.scene.step()

    def _aim_at_next_object(self, waypoint: Waypoint) -> None:
        """Go to the object that is easiest to grip, and close across a narrow side of it, with room for the fingers."""
        angles = np.arange(12) * np.pi / 12.0
        grips = [(name, angle) for name in self.left or OBJECTS[:1] for angle in angles]
        name, angle = min(grips, key=lambda grip: self._grip_cost(*grip))
        waypoint.frame.set_pose([*self.scene.body(name).position, np.cos(angle / 2.0), np.sin(angle / 2.0), 0.0, 0.0])

    def _grip_cost(self, name: str, angle: float) -> float:
        """Return how wide an object is between the fingers, plus tenfold how far these stand in a wall or on a neighbour [m]."""
        body = self.scene.body(name)
        across = np.array([-np.sin(angle), np.cos(angle), 0.0])
        width = float(np.abs(turned_back(across, body.quaternion)) @ np.ptp(body.bounds(), axis=0))
        tray = self.scene.body("big_tray")
        middle = turned_back(body.position - tray.position, tray.quaternion)[:2]
        reach = np.abs(turned_back(across, tray.quaternion))[:2] * FINGER + PAD
        crossed = float(np.maximum(np.abs(middle) + reach - INSIDE, 0.0).sum())
        for other in (self.scene.body(o) for o in OBJECTS if o != name):
            room = 0.5 * float(np.ptp(other.bounds(), axis=0).mean()) + PAD
            gaps = [np.linalg.norm((other.position - body.position - side * FINGER * across)[:2]) for side in (-1.0, 1.0)]
            crossed += sum(max(room - float(gap), 0.0) for gap in gaps)
        return width + 10.0 * crossed


def turned_back(vector: np.ndarray, quaternion: np.ndarray) -> np.ndarray:
    """Express a world vector (3,) in a frame of the given orientation."""
    axis, w = -quaternion[:3], quaternion[3]
    return vector + 2.0 * np.cross(axis, np.cross(axis, vector) + w * vector)
