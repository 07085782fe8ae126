"""Push in one drawer of a chest."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task


class CloseDrawer(Task):
    """One of three drawers is open by 10 cm and must move in by 6 cm; at success it may still be up to 4 cm open."""

    drawers = ("bottom", "middle", "top")

    def init_task(self) -> None:
        """Register nothing: the drawer is known only in `init_episode`."""

    def variation_count(self) -> int:
        """One for each drawer."""
        return len(self.drawers)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Open the requested drawer and aim at its front; success is that it moves in by 6 cm."""
        drawer = self.drawers[variation]
        joint = self.world.joint(f"chest/drawer_{drawer}")
        joint.set_position(0.1)
        self.world.frame("waypoint0").move_to(f"ahead_{drawer}")
        self.register_success_conditions([JointMoved(joint, 0.06)])
        return self.make_instructions(drawer=drawer)
