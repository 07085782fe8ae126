"""Every condition that a task may register."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.front_door import front_door
from rlbench_pin.tasks.conditions.combined import AllOf, AnyOf, InOrder
from rlbench_pin.tasks.conditions.condition import Condition
from rlbench_pin.tasks.conditions.detected import Detected, DetectedSeveral, TipInside
from rlbench_pin.tasks.conditions.follow_path import FollowPath
from rlbench_pin.tasks.conditions.grasped import Grasped, NothingGrasped
from rlbench_pin.tasks.conditions.has_color import HasColor
from rlbench_pin.tasks.conditions.joint_moved import JointMoved
from rlbench_pin.tasks.conditions.list_empty import ListEmpty

__all__ = [
    "AllOf",
    "AnyOf",
    "Condition",
    "Detected",
    "DetectedSeveral",
    "FollowPath",
    "Grasped",
    "HasColor",
    "InOrder",
    "JointMoved",
    "ListEmpty",
    "NothingGrasped",
    "TipInside",
]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
