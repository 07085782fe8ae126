"""Colours of variations, and robots."""

from __future__ import annotations

from collections.abc import Callable

from pyrep.robots.arms import UR5, Arm, Jaco, Mico, Panda, Sawyer
from pyrep.robots.end_effectors import BaxterGripper, Gripper, JacoGripper, MicoGripper, PandaGripper, Robotiq85Gripper
from rlbench_pin.tasks.palette import COLORS

colors: list[tuple[str, tuple[float, float, float]]] = [(name, rgb) for name, rgb in COLORS]
"""The 20 colours, name and RGB from 0 to 1; the place in the list is the variation of tasks that are about a colour."""

SUPPORTED_ROBOTS: dict[str, tuple[Callable[..., Arm], Callable[..., Gripper], int]] = {
    "panda": (Panda, PandaGripper, 7),
    "jaco": (Jaco, JacoGripper, 6),
    "mico": (Mico, MicoGripper, 6),
    "sawyer": (Sawyer, BaxterGripper, 7),
    "ur5": (UR5, Robotiq85Gripper, 6),
}
"""Robot -> class of its arm, of its gripper, number of its arm joints. Those that `MODELS` lacks cannot be made."""

MODELS = {"panda": "panda", "jaco": "jaco", "ur5": "ur5e"}
"""Robot -> our model of it."""
