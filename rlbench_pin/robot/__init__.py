"""Arms: descriptions, kinematics, dynamics, collisions and distances, by Pinocchio and Coal.

The package uses no simulator and no planner; worlds are passed as snapshots.
"""

from __future__ import annotations

from rlbench_pin.robot.collision import CollisionModel, Distance
from rlbench_pin.robot.description import DEFAULT_ROBOT, SUPPORTED_ROBOTS, RobotDescription, UnknownRobot, robot_description
from rlbench_pin.robot.distances import DistanceModel
from rlbench_pin.robot.dynamics import (
    DynamicsDerivatives,
    forward_dynamics_derivatives,
    inverse_dynamics_derivatives,
    jacobian_derivative,
    manipulability_gradient,
    payload_inertia,
)
from rlbench_pin.robot.model import FrameChoice, JointLimits, RobotModel
from rlbench_pin.robot.trajectory import Trajectory

__all__ = [
    "DEFAULT_ROBOT",
    "SUPPORTED_ROBOTS",
    "CollisionModel",
    "Distance",
    "DistanceModel",
    "DynamicsDerivatives",
    "FrameChoice",
    "JointLimits",
    "RobotDescription",
    "RobotModel",
    "Trajectory",
    "UnknownRobot",
    "forward_dynamics_derivatives",
    "inverse_dynamics_derivatives",
    "jacobian_derivative",
    "manipulability_gradient",
    "payload_inertia",
    "robot_description",
]
