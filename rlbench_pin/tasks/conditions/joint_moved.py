"""A joint has travelled."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

from rlbench_pin.tasks.conditions.condition import Condition

if TYPE_CHECKING:
    from rlbench_pin.sim import ObjectJoint


class JointMoved(Condition):
    """Holds while a joint is more than `distance` away from its value at the start of the episode, in either direction.

    Args:
        joint: The joint of an object.
        distance: Travel to exceed, [rad] or [m].
    """

    def __init__(self, joint: ObjectJoint, distance: float) -> None:
        self.joint, self.distance = joint, distance
        self.start = float(joint.position)

    def met(self) -> bool:
        return abs(float(self.joint.position) - self.start) > self.distance

    def reset(self) -> None:
        self.start = float(self.joint.position)

    def state(self) -> float:
        return self.start

    def set_state(self, state: object) -> None:
        self.start = cast(float, state)
