"""The Franka Emika Panda."""

from __future__ import annotations

from pyrep.robots.arms.arm import Arm


class Panda(Arm):
    """The Panda of the running world.

    Args:
        count: Which one, counted from 0; a world has one.
        max_velocity: No joint is faster in paths [rad/s].
        max_acceleration: No joint accelerates more in paths [rad/s^2].
        max_jerk: Accelerations change no faster in paths [rad/s^3]; from 1000 on they may jump.
    """

    def __init__(self, count: int = 0, max_velocity: float = 1.0, max_acceleration: float = 4.0, max_jerk: float = 1000) -> None:
        super().__init__(count, "Panda", 7, None, max_velocity, max_acceleration, max_jerk)
