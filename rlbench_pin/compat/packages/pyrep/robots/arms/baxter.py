"""The arms of the Rethink Baxter, which the catalogue does not have yet."""

from __future__ import annotations

from pyrep.robots.arms.arm import Arm


class BaxterLeft(Arm):
    """The left arm; making one raises an error that says which arms there are."""

    def __init__(self, count: int = 0, max_velocity: float = 1.0, max_acceleration: float = 4.0, max_jerk: float = 1000) -> None:
        super().__init__(count, "Baxter_leftArm", 7, None, max_velocity, max_acceleration, max_jerk)


class BaxterRight(Arm):
    """The right arm; making one raises an error that says which arms there are."""

    def __init__(self, count: int = 0, max_velocity: float = 1.0, max_acceleration: float = 4.0, max_jerk: float = 1000) -> None:
        super().__init__(count, "Baxter_rightArm", 7, None, max_velocity, max_acceleration, max_jerk)
