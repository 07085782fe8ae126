"""Motion planning for one arm: kinematics, search, smoothing, collision checks and timing.

`MotionPlanner` combines these modules. `problems` reads and writes planning problems.
"""

from rlbench_pin.planning.continuous_collision import Certificate, certify
from rlbench_pin.planning.kinematics import PoseRegion, self_motions, solve_ik, solve_pinned_ik, symmetric_poses
from rlbench_pin.planning.path import JointPath, curve_path, straight_path
from rlbench_pin.planning.plan import (
    ALGORITHMS,
    Algorithm,
    Method,
    Plan,
    PlannerConfig,
    PlanningListener,
    PlanReport,
    PlanRequest,
)
from rlbench_pin.planning.planner import MotionPlanner
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
