"""A joint has travelled."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

from rlbench_pin.tasks.conditions.condition import Condition
from rlbench_pin.tasks.conditions.parts import Movable, as_part
from rlbench_pin.values import as_number

if TYPE_CHECKING:
    from rlbench_pin.sim import ObjectJoint


class JointMoved(Condition):
    """Holds while a joint is more than `distance` away from its value at the start of the episode, in either direction.

    Args:
        joint: The joint of an object.
        distance: Travel to exceed, [rad] or [m].
    """

    def __init__(self, joint: ObjectJoint, distance: float) -> None:
        self.joint = as_part(joint, Movable, "joint", "a joint, such as `self.world.joint(name)`")
        self.distance = as_number(distance, "distance [rad] or [m]", least=0.0)
        self.start = float(joint.position)

    def met(self) -> bool:
        """Return whether the joint is far enough from its start now."""
        return abs(float(self.joint.position) - self.start) > self.distance

    def reset(self) -> None:
        """Take the present value of the joint as its start."""
        self.start = float(self.joint.position)

    def state(self) -> float:
        """Return the value at the start [rad] or [m]."""
        return self.start

    def set_state(self, state: object) -> None:
        """Set the value at the start [rad] or [m]."""
        self.start = cast(float, state)
