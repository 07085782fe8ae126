"""Control by optimisation: small controllers on Pinocchio, PlaCo and OSQP, each usable without a simulator.

A controller takes the measured state and a target as arrays, and returns a command as an array or a small record. All
controllers keep position, velocity and acceleration limits so that a next command always exists (`constraints`).
`ForeignSolver` is imported at its first use; it needs the extra `bench`.
"""

from __future__ import annotations

import lazy_loader as lazy

from rlbench_pin.control.compliant import CompliantConfig, CompliantFollowing
from rlbench_pin.control.differential_ik import DifferentialIK, DifferentialIKConfig, DifferentialIKQP
from rlbench_pin.control.following import ComputedTorque, TrackingReport, TrajectoryFollower, TrajectoryTracker, VelocityFollowing
from rlbench_pin.control.gripper import GripperCommand, GripperConfig, GripperController
from rlbench_pin.control.impedance import CartesianImpedance, JointImpedance
from rlbench_pin.control.operational_space import OperationalSpaceConfig, OperationalSpaceQP, TorqueCommand
from rlbench_pin.control.pose_ik import PoseIK, PoseIKConfig, PoseSolution
from rlbench_pin.control.predictive import CartesianMPC, PredictiveCommand, PredictiveConfig
from rlbench_pin.control.qp.constraints import HeldQuantity, JointBounds
from rlbench_pin.control.qp.objectives import PostureObjective, TipObjective
from rlbench_pin.control.qp.programs import OsqpSolver, QPSolver, QuadraticProgram
from rlbench_pin.control.safety_filter import FilterCounts, SafeCommand, SafetyConfig, SafetyFilter

__all__ = [
    "CartesianImpedance",
    "CartesianMPC",
    "CompliantConfig",
    "CompliantFollowing",
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

__getattr__, _, _ = lazy.attach(__name__, submod_attrs={"qp.foreign_solver": ["ForeignSolver"]})
