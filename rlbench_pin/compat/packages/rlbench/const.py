"""Colours of variations, and supported robots."""

from __future__ import annotations

from collections.abc import Callable

from pyrep.robots.arms import UR5, Arm, Jaco, Mico, Panda, Sawyer
from pyrep.robots.end_effectors import BaxterGripper, Gripper, JacoGripper, MicoGripper, PandaGripper, Robotiq85Gripper
from rlbench_pin.tasks.palette import COLORS

colors: list[tuple[str, tuple[float, float, float]]] = [(name, rgb) for name, rgb in COLORS]
"""The 20 colours, name and RGB from 0 to 1; the index is the variation of tasks whose variations are colours."""

SUPPORTED_ROBOTS: dict[str, tuple[Callable[..., Arm], Callable[..., Gripper], int]] = {
    "panda": (Panda, PandaGripper, 7),
    "jaco": (Jaco, JacoGripper, 6),
    "mico": (Mico, MicoGripper, 6),
    "sawyer": (Sawyer, BaxterGripper, 7),
    "ur5": (UR5, Robotiq85Gripper, 6),
}
"""Name -> class of the arm, class of the gripper, number of arm joints. Only the robots of `MODELS` can be created."""

MODELS = {"panda": "panda", "jaco": "jaco", "ur5": "ur5e"}
"""RLBench's name of a robot -> our name."""
