"""Move everything from a large tray into one of two small ones."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS, BodySpec, Detected, SpawnBoundary, Task, Waypoint, distractor_colors

OBJECTS = ("object0", "object1", "object2")
SOLIDS, SIZES = 25, 40
"""A thousand shapes: so many solids in so many sizes."""
DROP, APART = 0.2, 0.06
"""Height of the lowest object over the tray, and how much higher the next one starts [m]."""
PLACES = (-0.04, 0.04, 0.0)
"""Where the first, second and third object are let go along the small tray [m]."""
FALL = 20
"""Control ticks until the objects have come to rest."""
KNOCK, KNOCKS = 1.0, 2
"""Speed of turning with which what stands on an edge is knocked over [rad/s], and how often."""
SIDES = (0.0, -1.0, 1.0)
"""Where an object may be between the fingers: in the middle, or nearly at one of them."""
INSIDE = np.array([0.165, 0.135])
"""Half size of the inside of the large tray [m]."""
OPEN, FINGER, PAD = 0.028, 0.052, 0.008
"""How far the middle of the hand may be from a side of an object, how far an open finger reaches, and half its breadth [m]."""


class EmptyContainer(Task):
    """Three random objects must lie in the small tray of the asked colour."""

    def init_task(self) -> None:
        self.trays = [self.scene.body("tray0"), self.scene.body("tray1")]
        self.boundary = SpawnBoundary([self.scene.region("patch")])
        self.register_waypoint_ability_start(1, self._aim_at_next_object)
        self.register_waypoint_ability_start(3, self._aim_at_tray)
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
        self.goal_y = 0.25 * (2 * goal - 1)
        self._aim_at_tray()
        self.register_success_conditions([Detected(self.scene.body(o), self.sensor) for o in OBJECTS])
        return [
            f"Put everything from the large tray into the {name} one.",
            f"The three things in the middle belong in the {name} tray.",
            f"Empty the big container into the small {name} container.",
        ]

    def step(self) -> None:
        self.left[:] = [o for o in OBJECTS if not self.sensor.detects(o)]

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
        self._wait()
        for _ in range(KNOCKS):
            for angle, name in zip(rng.uniform(0.0, 2.0 * np.pi, len(OBJECTS)), OBJECTS, strict=True):
                self.scene.body(name).set_velocity([0.0, 0.0, 0.0, KNOCK * np.cos(angle), KNOCK * np.sin(angle), 0.0])
            self._wait()

    def _wait(self) -> None:
        for _ in range(FALL):
            self.scene.step()

    def _aim_at_next_object(self, waypoint: Waypoint) -> None:
        """Go to the object that is easiest to grip, and close across a narrow side of it, with room for the fingers."""
        angles = [n * np.pi / 12.0 for n in range(12)]
        grips = [grip for o in self.left or OBJECTS[:1] for angle in angles for grip in self._grips(o, angle)]
        _, place, angle = min(grips, key=lambda grip: grip[0])
        waypoint.frame.set_pose([*place, np.cos(angle / 2.0), np.sin(angle / 2.0), 0.0, 0.0])

    def _aim_at_tray(self, waypoint: Waypoint | None = None) -> None:
        """Let things go beside those that lie in the tray already, not onto them."""
        along = PLACES[len(OBJECTS) - max(len(self.left), 1)]
        self.scene.frame("waypoint3").set_local([along, self.goal_y, 0.17, 1.0, 0.0, 0.0, 0.0])

    def _grips(self, name: str, angle: float) -> list[tuple[float, np.ndarray, float]]:
        """Judge grips with the hand turned by `angle`, an object in its middle or nearly at one of the fingers.

        Returns:
            Of each: a cost [m], which is how wide the object is between the fingers, how far from the middle, and tenfold how far
            the fingers stand in a wall or on a neighbour; where the hand is (3,); the angle.
        """
        body = self.scene.body(name)
        across = np.array([-np.sin(angle), np.cos(angle), 0.0])
        turned = [*body.position, 0.0, 0.0, np.sin(angle / 2.0), np.cos(angle / 2.0)]
        low, high = body.bounds_from(turned)[:, 1]
        grips = []
        for side in SIDES:
            shift = side * max(OPEN - 0.5 * (high - low), 0.0)
            place = body.position + (0.5 * (low + high) + shift) * across
            crossed = sum(self._in_the_way(name, place + finger * across) for finger in (-FINGER, FINGER))
            grips.append((float(high - low) + 0.5 * abs(shift) + 10.0 * crossed, place, angle))
        return grips

    def _in_the_way(self, name: str, finger: np.ndarray) -> float:
        """Return how far a finger at a point stands in a wall or on what is not the object to grip [m]."""
        crossed = self._in_wall(finger)
        for other in (self.scene.body(o) for o in OBJECTS if o != name):
            room = 0.5 * float(np.ptp(other.bounds(), axis=0).mean()) + PAD
            crossed += max(room - float(np.linalg.norm((other.position - finger)[:2])), 0.0)
        return crossed

    def _in_wall(self, point: np.ndarray) -> float:
        """Return how far a finger at a point stands in a wall of the large tray [m]."""
        tray = self.scene.body("big_tray")
        inside = np.abs(turned_back(point - tray.position, tray.quaternion))[:2]
        return float(np.maximum(inside + PAD - INSIDE, 0.0).sum())


def turned_back(vector: np.ndarray, quaternion: np.ndarray) -> np.ndarray:
    """Express a world vector (3,) in a frame of the given orientation."""
    axis, w = -quaternion[:3], quaternion[3]
    return vector + 2.0 * np.cross(axis, np.cross(axis, vector) + w * vector)
