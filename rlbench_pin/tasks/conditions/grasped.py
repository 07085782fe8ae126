"""What the hand holds. Holding means being attached to the hand, not being touched."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.tasks.conditions.condition import Condition

if TYPE_CHECKING:
    from rlbench_pin.sim import Body, SimGripper


class Grasped(Condition):
    """Holds while `body` is attached to the hand.

    Args:
        gripper: The hand, `self.gripper`.
        body: A body that may be grasped.
    """

    def __init__(self, gripper: SimGripper, body: Body) -> None:
        self.gripper, self.body = gripper, body

    def met(self) -> bool:
        """Return whether the body is attached to the hand now."""
        return self.body.name in self.gripper.grasped


class NothingGrasped(Condition):
    """Holds while nothing is attached to the hand.

    Args:
        gripper: The hand, `self.gripper`.
    """

    def __init__(self, gripper: SimGripper) -> None:
        self.gripper = gripper

    def met(self) -> bool:
        """Return whether the hand holds nothing now."""
        return not self.gripper.grasped
