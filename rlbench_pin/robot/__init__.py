"""Arms as data and as models: descriptions, kinematics, dynamics, collisions and distances, by Pinocchio and Coal.

Nothing here uses a simulator or a planner; worlds come as snapshots.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.front_door import front_door
from rlbench_pin.robot.catalogue import DEFAULT_ROBOT, SUPPORTED_ROBOTS, UnknownRobot, robot_description
from rlbench_pin.robot.collision import CollisionModel
from rlbench_pin.robot.collision_geometry import Distance
from rlbench_pin.robot.derivatives import (
    DynamicsDerivatives,
    forward_dynamics_derivatives,
    inverse_dynamics_derivatives,
    jacobian_derivative,
    manipulability_gradient,
)
from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.robot.distances import DistanceModel
from rlbench_pin.robot.limits import JointLimits
from rlbench_pin.robot.model import FrameChoice, RobotModel
from rlbench_pin.robot.payload import payload_inertia
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

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
