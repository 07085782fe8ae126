"""The KUKA LBR iiwa 14 R820, which the catalogue does not have yet."""

from __future__ import annotations

from pyrep.robots.arms.arm import Arm


class LBRIwaa14R820(Arm):
    """The KUKA LBR iiwa 14 R820; making one raises an error that says which arms there are."""

    def __init__(self, count: int = 0, max_velocity: float = 1.0, max_acceleration: float = 4.0, max_jerk: float = 1000) -> None:
        super().__init__(count, "LBRIwaa14R820", 7, None, max_velocity, max_acceleration, max_jerk)
