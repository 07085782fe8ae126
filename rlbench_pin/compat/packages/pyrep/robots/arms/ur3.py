"""The Universal Robots UR3, which the catalogue does not have yet."""

from __future__ import annotations

from pyrep.robots.arms.arm import Arm


class UR3(Arm):
    """The Universal Robots UR3; making one raises an error that says which arms there are."""

    def __init__(self, count: int = 0, max_velocity: float = 1.0, max_acceleration: float = 4.0, max_jerk: float = 1000) -> None:
        super().__init__(count, "UR3", 6, None, max_velocity, max_acceleration, max_jerk)
