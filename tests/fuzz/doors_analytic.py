"""Doors of the analytic parts: poses, arms, limits, controllers, planning."""

from __future__ import annotations

import inspect

import numpy as np
import pinocchio as pin
from scipy.interpolate import make_interp_spline

from rlbench_pin import control, planning, robot, spatial
from rlbench_pin.planning.path import through
from rlbench_pin.robot import CollisionModel, DistanceModel, RobotModel, Trajectory, robot_description
from rlbench_pin.scene.snapshot import WorldSnapshot
from tests.fuzz.doors import Door, Fresh, functions, methods

RECORDS = frozenset({
    "QPSolver", "GripperCommand", "PoseSolution", "PredictiveCommand", "SafeCommand", "TorqueCommand", "TrackingReport",
    "QuadraticProgram", "HeldQuantity",
})  # fmt: skip
"""Of `control`: what its doors return, and names of types."""
POSES = (
    "above_table", "pose_to_se3", "se3_to_pose", "pose_to_matrix", "matrix_to_pose", "inverse", "relative", "euler_to_quaternion",
    "quaternion_yaw", "pose_at", "rotation_distance",
)  # fmt: skip
ARMS = (
    "JointLimits", "Trajectory", "RobotModel", "CollisionModel", "DistanceModel", "robot_description", "jacobian_derivative",
    "forward_dynamics_derivatives", "inverse_dynamics_derivatives", "manipulability_gradient", "payload_inertia",
)  # fmt: skip
PLANNING = (
    "MotionPlanner", "PlannerConfig", "PoseRegion", "TorqueLimits", "curve_path", "retime", "self_motions", "solve_ik",
    "solve_pinned_ik", "straight_path", "symmetric_poses", "certify", "JointPath",
)  # fmt: skip
LOOSE = {
    "JointLimits": "lower upper velocity acceleration effort",
    "JointLimits.contains": "tolerance",
    "CartesianImpedance": "stiffness",
    "JointImpedance": "stiffness",
    "CartesianMPC.command": "reference",
    "GripperController.update": "force",
    "MotionPlanner.plan_to_pose": "pose",
}
"""Limits may be infinite; some arguments stand for several or for one."""
FAST = (
    "place",
    "visit",
    "distance",
    "measure",
    "probe",
    "pairs_of",
    "gradients",
    "names",
    "wider",
    "update",
    "collides",
    "configuration",
)
"""Of `DistanceModel` and `CollisionModel`: inner loops of searches and of the safety filter, which check what they get."""


def samples(model: RobotModel) -> dict[str, object]:
    """Return good arguments by name."""
    q, zero, pose = model.home, np.zeros(model.size), model.tip_pose(model.home)
    points = np.array([q, q + 0.1])
    motion = Trajectory(np.array([0.0, 0.5, 1.0]), np.tile(q, (3, 1)), np.zeros((3, 7)), np.zeros((3, 7)))
    limits = model.limits
    plain: dict[str, object] = {
        "description": model.description, "model": model, "q": q, "v": zero, "a": zero, "tau": zero, "q_start": q,
        "q_goal": q + 0.1,
        "seed_q": q, "near": q, "q_seed": q, "pose": pose, "mass": 1.0, "center": np.zeros(3),
        "payload": pin.Inertia(1.0, np.zeros(3), np.eye(3)),
        "t": 0.5, "rng": Fresh(lambda: np.random.default_rng(1)), "wanted": zero, "twist": np.zeros(6), "reference": pose,
        "trajectory": motion, "limits": limits, "dt": 0.05, "q_target": q, "width": 0.04, "widest": 0.08, "force": 20.0,
        "velocity": 0.5, "acceleration": 1.0, "lower": limits.lower, "upper": limits.upper, "effort": limits.effort,
        "times": motion.times, "name": "panda", "poses": [pose], "goal": pose, "pinned": {0: float(q[0])}, "order": 2,
        "path": points,
        "distance": 0.01, "count": 1, "roll": 0.1, "pitch": 0.1, "yaw": 0.1, "position": np.zeros(3), "matrix": np.eye(4),
        "quaternion": np.array([0.0, 0.0, 0.0, 1.0]), "height": 0.1, "b": pose, "transform": pin.SE3.Identity(),
        "backend": control.VelocityFollowing(limits), "config": control.GripperConfig(widest=0.08, force=20.0),
        "names": ["cube"],
        "snapshot": WorldSnapshot((), q, np.full(2, 0.04)), "collision": CollisionModel(model),
    }  # fmt: skip
    special: dict[str, object] = {
        "JointLimits.velocity": limits.velocity, "JointLimits.acceleration": limits.acceleration, "Trajectory.q": motion.q,
        "Trajectory.v": motion.v, "Trajectory.a": motion.a, "rotation_distance.a": pose, "certify.path": through(points),
        "PoseRegion.center": pose, "JointPath.spline": pin_spline(points), "TorqueLimits.surely_kept.acceleration": np.ones(7),
        "MotionPlanner.config": planning.PlannerConfig(), "CollisionModel.begin.allowed": ["cube"],
    }  # fmt: skip
    return plain | special


def pin_spline(points: np.ndarray) -> object:
    """Return a spline as `JointPath` takes it."""
    return make_interp_spline(np.linspace(0.0, 1.0, 4), np.linspace(points[0], points[1], 4), k=3)


def controllers(model: RobotModel) -> list[object]:
    """Return one of each controller."""
    return [
        control.CartesianImpedance(model), control.CartesianMPC(model), control.ComputedTorque(model),
        control.DifferentialIK(model), control.DifferentialIKQP(model), control.JointImpedance(model),
        control.GripperController(control.GripperConfig(widest=0.08, force=20.0)), control.OperationalSpaceQP(model),
        control.PoseIK(model), control.SafetyFilter(model), control.VelocityFollowing(model.limits),
    ]  # fmt: skip


def analytic_doors() -> list[Door]:
    """Return all of them."""
    model = RobotModel(robot_description("panda"))
    good = samples(model)
    classes = [name for name in control.__all__ if inspect.isclass(getattr(control, name)) and name not in RECORDS]
    doors = functions(spatial, POSES, good, LOOSE) + functions(robot, ARMS, good, LOOSE)
    doors += functions(control, classes, good, LOOSE) + functions(planning, PLANNING, good, LOOSE)
    things = [RobotModel(model.description), model.limits, good["trajectory"], planning.TorqueLimits(model)]
    for thing in (*things, *controllers(model)):
        doors += methods(thing, good, LOOSE, skip=("problem",))
    for thing in (planning.MotionPlanner(model), CollisionModel(model), DistanceModel(model)):
        doors += methods(thing, good, LOOSE, skip=FAST)
    return doors
