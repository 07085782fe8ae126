"""Control by optimisation: small controllers on Pinocchio, PlaCo and OSQP, each usable alone, without a simulator.

Each takes the measured state and a target as arrays and returns a command as an array or a small record. All of them keep
position, velocity and acceleration limits in such a way that there always is a next command (`constraints`).
`ForeignSolver` is imported when first used; it needs the extra `bench`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.control.differential_ik import DifferentialIK, DifferentialIKConfig
from rlbench_pin.control.differential_ik_qp import DifferentialIKQP
from rlbench_pin.control.following import ComputedTorque, TrackingReport, TrajectoryFollower, VelocityFollowing
from rlbench_pin.control.gripper import GripperCommand, GripperConfig, GripperController
from rlbench_pin.control.impedance import CartesianImpedance, JointImpedance
from rlbench_pin.control.operational_space import OperationalSpaceConfig, OperationalSpaceQP, TorqueCommand
from rlbench_pin.control.pose_ik import PoseIK, PoseIKConfig, PoseSolution
from rlbench_pin.control.predictive import CartesianMPC, PredictiveCommand, PredictiveConfig
from rlbench_pin.control.qp.constraints import HeldQuantity, JointBounds
from rlbench_pin.control.qp.objectives import PostureObjective, TipObjective
from rlbench_pin.control.qp.osqp_solver import OsqpSolver
from rlbench_pin.control.qp.quadratic_program import QPSolver, QuadraticProgram
from rlbench_pin.control.safety_filter import SafetyFilter
from rlbench_pin.control.safety_records import FilterCounts, SafeCommand, SafetyConfig
from rlbench_pin.control.tracking import TrajectoryTracker
from rlbench_pin.front_door import front_door

__all__ = [
    "CartesianImpedance",
    "CartesianMPC",
    "ComputedTorque",
    "DifferentialIK",
    "DifferentialIKConfig",
    "DifferentialIKQP",
    "FilterCounts",
    "GripperCommand",
    "GripperConfig",
    "GripperController",
    "HeldQuantity",
    "JointBounds",
    "JointImpedance",
    "OperationalSpaceConfig",
    "OperationalSpaceQP",
    "OsqpSolver",
    "PoseIK",
    "PoseIKConfig",
    "PoseSolution",
    "PostureObjective",
    "PredictiveCommand",
    "PredictiveConfig",
    "QPSolver",
    "QuadraticProgram",
    "SafeCommand",
    "SafetyConfig",
    "SafetyFilter",
    "TipObjective",
    "TorqueCommand",
    "TrackingReport",
    "TrajectoryFollower",
    "TrajectoryTracker",
    "VelocityFollowing",
]

if TYPE_CHECKING:
    from rlbench_pin.control.qp.foreign_solver import ForeignSolver as ForeignSolver
else:
    __getattr__, __dir__ = front_door(__name__, {"ForeignSolver": "qp.foreign_solver"})
