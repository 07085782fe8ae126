"""Motions of one arm, from where it is to where it should be: kinematics, search, smoothing, proof and timing.

`MotionPlanner` does all of it; the parts are in `kinematics`, `search`, `proof`, `timing`, and problems as files in `problems`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.front_door import front_door
from rlbench_pin.planning.kinematics import PoseRegion, self_motions, solve_ik, solve_pinned_ik, symmetric_poses
from rlbench_pin.planning.listener import PlanningListener, PlanRequest
from rlbench_pin.planning.path import JointPath
from rlbench_pin.planning.plan import Method, Plan, PlannerConfig, PlanReport
from rlbench_pin.planning.planner import MotionPlanner
from rlbench_pin.planning.proof import Certificate, certify
from rlbench_pin.planning.search import ALGORITHMS, Algorithm
from rlbench_pin.planning.straight import curve_path, straight_path
from rlbench_pin.planning.timing import TorqueLimits, retime

__all__ = [
    "ALGORITHMS",
    "Algorithm",
    "Certificate",
    "JointPath",
    "Method",
    "MotionPlanner",
    "Plan",
    "PlanReport",
    "PlanRequest",
    "PlannerConfig",
    "PlanningListener",
    "PoseRegion",
    "TorqueLimits",
    "certify",
    "curve_path",
    "retime",
    "self_motions",
    "solve_ik",
    "solve_pinned_ik",
    "straight_path",
    "symmetric_poses",
]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
