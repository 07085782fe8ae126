"""Pull out one drawer of a chest."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task


class OpenDrawer(Task):
    """The requested one of three drawers must move out by 15 cm."""

    drawers: tuple[str, ...] = ("bottom", "middle", "top")

    def init_task(self) -> None:
        """Register nothing: the drawer is known only in `init_episode`."""

    def variation_count(self) -> int:
        """One for each drawer."""
        return len(self.drawers)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Aim at the handle of the requested drawer; success is that it moves out by 15 cm."""
        drawer = self.drawers[variation]
        self.world.frame("waypoint1").move_to(f"handle_{drawer}")
        self.register_success_conditions([JointMoved(self.world.joint(f"chest/drawer_{drawer}"), 0.15)])
        named, count = drawer.replace("_", " "), {3: "three", 4: "four"}[len(self.drawers)]
        return self.make_instructions(drawer=named, count=count)
