"""Bring the gripper tip to one of three floating balls."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS, NO_ROTATION, SpawnBoundary, Task, TipInside, distractor_colors


class ReachTarget(Task):
    """The gripper tip must be inside the ball of the requested colour. All three balls are at random places in a box."""

    solved_by_chance = True

    def init_task(self) -> None:
        """Success is the tip inside the target ball."""
        self.target = self.world.body("target")
        self.distractors = [self.world.body("distractor0"), self.world.body("distractor1")]
        self.boundary = SpawnBoundary([self.world.region("boundary")])
        self.register_success_conditions([TipInside(self.robot, self.world.sensor("goal"))])

    def variation_count(self) -> int:
        """One for each colour of the target."""
        return len(COLORS)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Colour and place the three balls, at least 20 cm apart."""
        name, rgb = COLORS[variation]
        others = distractor_colors(rng, variation, len(self.distractors))
        self.boundary.clear()
        for ball, color in zip([self.target, *self.distractors], [rgb, *(c.rgb for c in others)], strict=True):
            ball.set_color(color)
            self.boundary.sample(ball, rng, min_rotation=NO_ROTATION, max_rotation=NO_ROTATION, min_distance=0.2)
        return self.make_instructions(color=name)

    def reward(self) -> float:
        """Return minus the distance from the tip to the target [m]."""
        return -float(np.linalg.norm(self.robot.tip_pose()[:3] - self.target.position))

    def get_low_dim_state(self) -> np.ndarray:
        """Return the position of the target, shape (3,) [m]."""
        return np.array(self.target.position)
