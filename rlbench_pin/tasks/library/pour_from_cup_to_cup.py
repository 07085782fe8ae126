"""Pour the contents of one cup into another."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rlbench_pin.tasks import COLORS, BodySpec, BoundaryError, Detected, SpawnBoundary, Task, distractor_colors

RINGS = (
    (0.0, 0.0100, (0,)),
    (0.0101, 0.0100, (-108, -44, 16, 75, 135, 194)),
    (0.0196, 0.0100, tuple(range(-93, 267, 30))),
    (0.0059, 0.0180, (-77,)),
)
"""Where twenty drops come to rest in a cup: distance from its axis and height [m], directions [degrees]."""
TURNS = (
    ((0.4, 0.55, 0.7, 0.25, 0.85), (0.9, 0.75, 0.6, 1.05)),
    ((-0.4, -0.55, -0.7, -0.25, -0.85), (-0.3, -0.45, -0.6)),
)
"""Where the hand may point when it grips and when it pours, best first, from straight away from the arm [rad].

Both lie on the same side, so that the arm does not pass its stretched posture in between."""
LANE, DEPTH = 0.14, 0.3
"""Half breadth and length of what must be free behind a cup for the hand [m]."""
MAX_LAYOUTS = 200


class PourFromCupToCup(Task):
    """All twenty drops must be in the lower part of the target cup. Three more cups stand around."""

    def init_task(self) -> None:
        self.source, self.target = self.world.body("source"), self.world.body("target")
        self.others = [self.world.body(f"distractor{i}") for i in range(3)]
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.drops = [f"drop{i}" for i in range(sum(len(directions) for _, _, directions in RINGS))]
        self.register_graspable_objects(["source"])

    def variation_count(self) -> int:
        return len(COLORS)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        source, target = COLORS[variation], COLORS[(variation + 1) % len(COLORS)]
        self.source.set_color(source.rgb)
        self.target.set_color(target.rgb)
        free = [color for color in distractor_colors(rng, variation, 4) if color != target]
        for body, color in zip(self.others, free, strict=False):
            body.set_color(color.rgb)
        self._lay_out(rng)
        self._fill(rng)
        sensor = self.world.sensor("in_target")
        self.register_success_conditions([Detected(self.world.body(drop), sensor) for drop in self.drops])
        return [
            f"Pour the drink from the {source.name} cup into the {target.name} cup.",
            f"Tip the {source.name} cup so that all of it lands in the {target.name} one.",
            f"What is in the {source.name} cup should be in the {target.name} cup.",
        ]

    def _lay_out(self, rng: np.random.Generator) -> None:
        """Place the cups so that the hand can come to source and target from somewhere in front."""
        for _ in range(MAX_LAYOUTS):
            self.boundary.clear()
            for body in (self.source, self.target, *self.others):
                self.boundary.sample(body, rng, min_distance=0.12)
            for grip, pour in TURNS:
                turns = self._free_turn(self.source.position, grip), self._free_turn(self.target.position, pour)
                if turns[0] is not None and turns[1] is not None:
                    self._aim({"grip": turns[0], "pour": turns[1]})
                    return
        raise BoundaryError(f"In {MAX_LAYOUTS} layouts no lane for the hand was free. Enlarge the patch of the cups.")

    def _aim(self, turns: dict[str, float]) -> None:
        """Turn the frames that the hand comes along."""
        for name, turn in turns.items():
            frame = self.world.frame(name)
            frame.set_pose([*frame.position, 0.0, 0.0, np.sin(turn / 2.0), np.cos(turn / 2.0)])

    def _free_turn(self, place: np.ndarray, turns: Sequence[float]) -> float | None:
        """Return the first direction in which no other cup is in the way of the hand that points to a cup."""
        x, y = (place - np.array(self.robot.description.base_pose[:3]))[:2]
        others = [body.position[:2] - place[:2] for body in (self.source, self.target, *self.others)]
        for turn in np.arctan2(y, x) + np.array(turns):
            ahead, side = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
            if not any(0.0 < -(d @ ahead) < DEPTH and abs(d @ side) < LANE for d in others):
                return float(turn)
        return None

    def _fill(self, rng: np.random.Generator) -> None:
        """Create the drops in the source cup: a layer that fills its floor, one on top, turned at random."""
        turn = rng.uniform(0.0, 2.0 * np.pi)
        places: list[tuple[float, float, float]] = []
        for radius, height, directions in RINGS:
            angles = turn + np.radians(directions)
            places += [(float(radius * np.cos(angle)), float(radius * np.sin(angle)), height) for angle in angles]
        for drop, place in zip(self.drops, places, strict=True):
            self.world.add_body(
                drop, BodySpec(name=drop, asset="objects/drop/drop.urdf", parent="source", pose=(*place, 0.0, 0.0, 0.0, 1.0))
            )
