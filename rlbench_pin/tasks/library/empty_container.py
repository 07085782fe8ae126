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
KNOCK, KNOCKS = 3.0, 2
"""Speed of turning with which what stands on an edge is knocked over [rad/s], and how often."""
PUSH, MAX_PUSHES = 0.4, 8
"""Speed with which objects are pushed apart that do not come to rest [m/s], and how often at most."""
STILL = 2e-4
"""What an object at rest may move [m] or turn (part of a quaternion) within a second."""
SIDES = (0.0, -1.0, 1.0)
"""Where an object may be between the fingers: in the middle, or nearly at one of them."""
INSIDE = np.array([0.165, 0.135])
"""Half size of the inside of the large tray [m]."""
OPEN, FINGER = 0.028, 0.053
"""How far the middle of the hand may be from a side of an object, and from the middle of an open finger [m]."""
PAD = np.array([0.014, 0.016])
"""Half size of the place that a finger needs, along its breadth and its thickness [m]."""
CORNERS = np.array([[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]])
ANGLES = 24
"""Turns of the hand that are judged."""


class EmptyContainer(Task):
    """Three random objects must lie in the small tray of the asked colour."""

    def init_task(self) -> None:
        self.trays = [self.world.body("tray0"), self.world.body("tray1")]
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_waypoint_ability_start(0, self._aim_at_next_object)
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
        self.sensor = self.world.sensor(f"in_tray{goal}")
        self.left = list(OBJECTS)
        self.goal_y = 0.25 * (2 * goal - 1)
        self._aim_at_tray()
        self.register_success_conditions([Detected(self.world.body(o), self.sensor) for o in OBJECTS])
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
            body = self.world.add_body(OBJECTS[i], spec)
            self.boundary.sample(body, rng, min_distance=0.0, ignore_collisions=True)
        self.register_graspable_objects(OBJECTS)
        self._settle(rng)

    def _settle(self, rng: np.random.Generator) -> None:
        """Let the objects fall, knock over what stands on an edge, and push apart what leans and creeps."""
        self._wait()
        for _ in range(KNOCKS):
            self._knock(rng)
        pushes = 0
        while self._wait() >= STILL and pushes < MAX_PUSHES:
            self._knock(rng, PUSH)
            pushes += 1

    def _knock(self, rng: np.random.Generator, push: float = 0.0) -> None:
        """Turn every object about a random horizontal axis, push it away from the others, and wait."""
        for angle, name in zip(rng.uniform(0.0, 2.0 * np.pi, len(OBJECTS)), OBJECTS, strict=True):
            along = push * self._away(name)
            self.world.body(name).set_velocity([*along, 0.0, KNOCK * np.cos(angle), KNOCK * np.sin(angle), 0.0])
        self._wait()

    def _away(self, name: str) -> np.ndarray:
        """Return the horizontal direction (2,) from the middle of all objects to one of them."""
        away = (self.world.body(name).position - np.mean([self.world.body(o).position for o in OBJECTS], axis=0))[:2]
        return away / max(float(np.linalg.norm(away)), 1e-6)

    def _wait(self) -> float:
        """Wait a second, and return how much any object has moved or turned, the largest change of a number of its pose."""
        before = [self.world.body(name).pose for name in OBJECTS]
        for _ in range(FALL):
            self.world.step()
        return max(float(np.abs(self.world.body(n).pose - pose).max()) for n, pose in zip(OBJECTS, before, strict=True))

    def _aim_at_next_object(self, waypoint: Waypoint) -> None:
        """Go over, then down to the object that is easiest to grip, across a narrow side of it and with room for the fingers."""
        grips = [grip for n in range(ANGLES) for grip in self._grips(n * np.pi / ANGLES)]
        _, place, angle = min(grips, key=lambda grip: grip[0])
        if waypoint.index == 0:
            place[2] = waypoint.frame.position[2]
        waypoint.frame.set_pose([*place, np.cos(angle / 2.0), np.sin(angle / 2.0), 0.0, 0.0])

    def _aim_at_tray(self, waypoint: Waypoint | None = None) -> None:
        """Let things go beside those that lie in the tray already, not onto them."""
        along = PLACES[len(OBJECTS) - max(len(self.left), 1)]
        self.world.frame("waypoint3").set_local([along, self.goal_y, 0.17, 1.0, 0.0, 0.0, 0.0])

    def _grips(self, angle: float) -> list[tuple[float, np.ndarray, float]]:
        """Judge grips with the hand turned by `angle`, every object in its middle or nearly at one of the fingers.

        Returns:
            Of each: a cost [m], which is how wide the object is between the fingers, how far from the middle, and tenfold how far
            the fingers stand in a wall or on another object; where the hand is (3,); the angle.
        """
        turn, tray = turn_by(angle), self.world.body("big_tray").pose
        tray_turn = turn_by(2.0 * np.arctan2(tray[5], tray[6]))
        hand = [0.0, 0.0, 0.0, 0.0, 0.0, np.sin(angle / 2.0), np.cos(angle / 2.0)]
        boxes = {o: self.world.body(o).bounds_from(hand)[:, :2] for o in OBJECTS}
        grips = []
        for name in self.left or OBJECTS[:1]:
            position = self.world.body(name).position
            along, across = position[:2] @ turn
            low, high = boxes[name][:, 1]
            others = np.stack([box for o, box in boxes.items() if o != name])
            for side in SIDES:
                shift = side * max(OPEN - 0.5 * (high - low), 0.0)
                fingers = np.array([[along, 0.5 * (low + high) + shift + finger] for finger in (-FINGER, FINGER)])
                corners = (fingers[:, None] + CORNERS * PAD) @ turn.T - tray[:2]
                crossed = in_walls(corners @ tray_turn) + in_boxes(fingers, others)
                place = np.append(turn @ fingers.mean(axis=0), position[2])
                grips.append((float(high - low) + 0.5 * abs(shift) + 10.0 * crossed, place, angle))
        return grips


def turn_by(angle: float) -> np.ndarray:
    """Return the rotation of a plane (2, 2) by an angle [rad]."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def in_walls(corners: np.ndarray) -> float:
    """Return how far two fingers, their corners (2, 4, 2) given in the axes of the large tray, stand in its walls [m]."""
    return float(np.maximum(np.abs(corners) - INSIDE, 0.0).max(axis=(1, 2)).sum())


def in_boxes(fingers: np.ndarray, boxes: np.ndarray) -> float:
    """Return how far two fingers (2, 2) stand in boxes (n, 2, 2) [[min], [max]], all in the axes of the hand [m]."""
    middles = fingers[:, None]
    depth = np.minimum(boxes[:, 1] - middles, middles - boxes[:, 0]) + PAD
    return float(np.maximum(depth.min(axis=-1), 0.0).sum())
