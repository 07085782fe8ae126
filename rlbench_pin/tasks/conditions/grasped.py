"""What the hand holds. Holding means being attached to the hand, not being touched."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.tasks.conditions.condition import Condition
from rlbench_pin.tasks.conditions.parts import Holder, Placed, as_part

if TYPE_CHECKING:
    from rlbench_pin.sim import Body, SimGripper


def _as_hand(value: SimGripper) -> SimGripper:
    return as_part(value, Holder, "gripper", "the hand, `self.gripper`")


class Grasped(Condition):
    """Holds while `body` is attached to the hand.

    Args:
        gripper: The hand, `self.gripper`.
        body: A body that may be grasped.
    """

    def __init__(self, gripper: SimGripper, body: Body) -> None:
        self.gripper = _as_hand(gripper)
        self.body = as_part(body, Placed, "body", "a body, such as `self.world.body(name)`")

    def met(self) -> bool:
        """Return whether the body is attached to the hand now."""
        return self.body.name in self.gripper.grasped


class NothingGrasped(Condition):
    """Holds while nothing is attached to the hand.

    Args:
        gripper: The hand, `self.gripper`.
    """

    def __init__(self, gripper: SimGripper) -> None:
        self.gripper = _as_hand(gripper)

    def met(self) -> bool:
        """Return whether the hand holds nothing now."""
        return not self.gripper.grasped
