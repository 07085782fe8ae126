"""Push one block along the table until it meets the other."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS, Detected, Task, distractor_colors

FARTHEST = 0.03
"""Maximum shift of the standing block from its pose in the scene file [m]."""


class JoinBlocks(Task):
    """The pushed block must come within 6 mm of the standing one. The colours and the gap vary; no block can be grasped."""

    def init_task(self) -> None:
        """Success: the pushed block is in the thin volume in front of the standing block, which moves with it."""
        self.pushed, self.standing = self.world.body("pushed"), self.world.body("standing")
        self.register_success_conditions([Detected(self.pushed, self.world.sensor("near_face"))])

    def variation_count(self) -> int:
        """One for each colour of the pushed block."""
        return len(COLORS)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Colour both blocks and draw the gap between them."""
        name, rgb = COLORS[variation]
        other = distractor_colors(rng, variation, 1)[0]
        self.pushed.set_color(rgb)
        self.standing.set_color(other.rgb)
        self.standing.set_pose(self.standing.pose + np.array([rng.uniform(0.0, FARTHEST), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]))
        return [
            f"Push the {name} block against the other one.",
            f"Bring the {name} block and its neighbour together.",
            f"Close the gap between the blocks by moving the {name} one.",
        ]
