"""Pour the contents of one cup into another."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS, BodySpec, Detected, SpawnBoundary, Task, distractor_colors, free_direction

RINGS = (
    (0.0, 0.0100, (0,)),
    (0.0101, 0.0100, (-108, -44, 16, 75, 135, 194)),
    (0.0196, 0.0100, tuple(range(-93, 267, 30))),
    (0.0059, 0.0180, (-77,)),
)
"""Resting places of twenty drops in a cup: distance from its axis and height [m], directions [degrees]."""
TURNS = (
    ((0.4, 0.55, 0.7, 0.25, 0.85), (0.9, 0.75, 0.6, 1.05)),
    ((-0.4, -0.55, -0.7, -0.25, -0.85), (-0.3, -0.45, -0.6)),
)
"""Directions of the gripper during the grasp and during the pouring, best first; 0 points away from the arm [rad].

Both are on the same side, so that the arm does not pass through its stretched posture in between."""
LANE, DEPTHS = 0.14, (0.42, 0.3)
"""Half width of the free space behind a cup for gripper and wrist, and its length behind source and target [m].

The gripper stops 0.1 before the source, and moves over other cups to the target."""


class PourFromCupToCup(Task):
    """All twenty drops must be in the lower part of the target cup. There are three more cups."""

    def init_task(self) -> None:
        """The source cup may be grasped."""
        self.source, self.target = self.world.body("source"), self.world.body("target")
        self.others = [self.world.body(f"distractor{i}") for i in range(3)]
        self.cups = [self.source, self.target, *self.others]
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.drops = [f"drop{i}" for i in range(sum(len(directions) for _, _, directions in RINGS))]
        self.register_graspable_objects(["source"])

    def variation_count(self) -> int:
        """One for each colour of the source cup."""
        return len(COLORS)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Colour and place five cups and fill the source cup; success is every drop in the target cup."""
        source, target = COLORS[variation], COLORS[(variation + 1) % len(COLORS)]
        self.source.set_color(source.rgb, "cup")
        self.target.set_color(target.rgb, "cup")
        free = [color for color in distractor_colors(rng, variation, 4) if color != target]
        for body, color in zip(self.others, free, strict=False):
            body.set_color(color.rgb, "cup")
        self.boundary.scatter(self.cups, rng, min_distance=0.12, accept=self._aim)
        self._fill(rng)
        sensor = self.world.sensor("in_target")
        self.register_success_conditions([Detected(self.world.body(drop), sensor) for drop in self.drops])
        return self.make_instructions(source=source.name, target=target.name)

    def _aim(self) -> bool:
        """Turn the approach frames to directions without a cup in the way; return whether there are such directions."""
        for turns in TURNS:
            grip, pour = (
                self._free_turn(cup.position, best, depth)
                for cup, best, depth in zip((self.source, self.target), turns, DEPTHS, strict=True)
            )
            if grip is not None and pour is not None:
                for name, turn in (("grip", grip), ("pour", pour)):
                    frame = self.world.frame(name)
                    frame.set_pose([*frame.position, 0.0, 0.0, np.sin(turn / 2.0), np.cos(turn / 2.0)])
                return True
        return False

    def _free_turn(self, place: np.ndarray, turns: tuple[float, ...], depth: float) -> float | None:
        x, y = (place - np.array(self.robot.description.base_pose[:3]))[:2]
        others = [cup.position[:2] for cup in self.cups]
        return free_direction(place[:2], np.arctan2(y, x) + np.array(turns), others, LANE, depth)

    def _fill(self, rng: np.random.Generator) -> None:
        """Create the drops in the source cup: a layer that fills its floor and one drop on top, at a random yaw."""
        turn, places = rng.uniform(0.0, 2.0 * np.pi), []
        for radius, height, directions in RINGS:
            places += [(float(radius * np.cos(a)), float(radius * np.sin(a)), height) for a in turn + np.radians(directions)]
        for drop, place in zip(self.drops, places, strict=True):
            pose = (*place, 0.0, 0.0, 0.0, 1.0)
            self.world.add_body(drop, BodySpec(name=drop, asset="objects/drop/drop.urdf", parent="source", pose=pose))
