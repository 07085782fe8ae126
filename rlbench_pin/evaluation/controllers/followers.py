"""Every controller as a follower of one and the same joint trajectory, so that they can be compared.

What a controller needs of the trajectory (tip poses, twists, accelerations) is computed beforehand: a tick costs what the
controller itself costs.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from rlbench_pin.control import (
    CartesianImpedance,
    CartesianMPC,
    ComputedTorque,
    DifferentialIK,
    DifferentialIKConfig,
    DifferentialIKQP,
    JointImpedance,
    OperationalSpaceConfig,
    OperationalSpaceQP,
    PredictiveConfig,
    SafetyConfig,
    SafetyFilter,
    VelocityFollowing,
)
from rlbench_pin.environment.actions.safe_arm import LIMIT_MARGIN
from rlbench_pin.robot.distances import DistanceModel
from rlbench_pin.robot.dynamics import payload_inertia
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.robot.trajectory import Trajectory
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.sim import DriveMode
from rlbench_pin.spatial import FloatArray, pose_to_se3, se3_to_pose

MARGIN = 0.003
"""Distance to the world that filters and predictions keep [m]; small, because planned motions come near what they grasp."""
TIP_STIFFNESS = (3000.0, 3000.0, 3000.0, 150.0, 150.0, 150.0)
"""[N/m, N m/rad]: the spring of Cartesian impedance control."""
ELBOW_STIFFNESS = 10.0
"""[N m/rad]: its spring on the motion of the elbow that leaves the tip where it is."""
OVERTIME = 20
"""Control ticks that a controller may take to arrive after the end of the motion."""


@dataclass(frozen=True, eq=False)
class TrackingProblem:
    """One trajectory to follow, and all that a controller may use."""

    model: RobotModel
    """The arm, without payload."""
    trajectory: Trajectory
    """Timed joint motion that starts where the arm is."""
    world: WorldSnapshot
    """The world at the start."""
    touching: Collection[str]
    """Bodies that the arm touches at the start."""
    control_dt: float
    """Control tick [s]."""
    physics_dt: float
    """Physics step [s]."""

    def model_with_payload(self) -> RobotModel:
        """Return a model of the arm that carries what the hand holds at the start."""
        model = RobotModel(self.model.description, se3_to_pose(self.model.base))
        model.carry(payload_inertia(self.model, self.world))
        return model


@dataclass(frozen=True, eq=False)
class Command:
    """What a controller commands for the next tick."""

    values: FloatArray
    """Joint positions [rad], velocities [rad/s] or torques [N m], shape (n,)."""
    stopped: bool = False
    """The controller found no solution and brakes."""
    intervened: bool = False
    """A safety filter changed the command."""


@dataclass(frozen=True)
class Follower:
    """A controller that knows the trajectory it follows."""

    mode: DriveMode
    """Kind of its commands; torques are commanded in every physics step, the others once per control tick."""
    command: Callable[[int, FloatArray, FloatArray], Command]
    """Command of tick k in state q [rad], v [rad/s]."""


def track_positions(problem: TrackingProblem) -> Follower:
    """Position targets, one tick ahead, as demonstrations do."""
    goals = _configurations(problem, problem.control_dt)
    return Follower("position", lambda k, q, v: Command(goals[min(k + 1, len(goals) - 1)]))


def follow_velocities(problem: TrackingProblem) -> Follower:
    """`VelocityFollowing`: the reference's velocity and a share of the error."""
    backend = VelocityFollowing(problem.model.limits, problem.control_dt)
    return Follower("velocity", lambda k, q, v: Command(backend.command(problem.trajectory, k * backend.dt, q, v)))


def computed_torque(problem: TrackingProblem) -> Follower:
    """`ComputedTorque` in every physics step."""
    backend = ComputedTorque(problem.model_with_payload(), problem.physics_dt)
    return Follower("torque", lambda k, q, v: Command(backend.command(problem.trajectory, k * backend.dt, q, v)))


def follow_poses(problem: TrackingProblem) -> Follower:
    """`DifferentialIK` towards the tip pose one tick ahead; it brakes for each pose as for a last one."""
    solver, poses = _differential_ik(problem), _tip_poses(problem, problem.control_dt)
    return Follower("velocity", lambda k, q, v: Command(solver.velocity_to_pose(q, v, _at(poses, k + 1))))


def follow_twists(problem: TrackingProblem) -> Follower:
    """`DifferentialIK` with the tip velocity that reaches the pose one tick ahead."""
    return _twists(problem, _differential_ik(problem))


def follow_twists_by_osqp(problem: TrackingProblem) -> Follower:
    """`DifferentialIKQP`, the same problem by OSQP."""
    config = DifferentialIKConfig(dt=problem.control_dt)
    return _twists(problem, DifferentialIKQP(problem.model, config, posture=problem.trajectory.q[-1]))


def _twists(problem: TrackingProblem, solver: DifferentialIK | DifferentialIKQP) -> Follower:
    poses = _tip_poses(problem, problem.control_dt)

    def command(k: int, q: FloatArray, v: FloatArray) -> Command:
        here, goal = problem.model.tip_se3(q), pose_to_se3(_at(poses, k + 1))
        turn = pin.log3(goal.rotation @ here.rotation.T)
        twist = np.concatenate([goal.translation - here.translation, turn]) / problem.control_dt
        return Command(solver.velocity_for_twist(q, v, twist))

    return Follower("velocity", command)


def predict(problem: TrackingProblem, avoid: bool = False) -> Follower:
    """`CartesianMPC` on the tip poses of the next ticks."""
    distances = _distances(problem) if avoid else None
    config = PredictiveConfig(dt=problem.control_dt, margin=MARGIN, self_margin=MARGIN)
    solver = CartesianMPC(problem.model, config, distances=distances, posture=problem.trajectory.q[-1])
    poses = _tip_poses(problem, problem.control_dt)

    def command(k: int, q: FloatArray, v: FloatArray) -> Command:
        ahead = np.minimum(np.arange(k + 1, k + 1 + config.horizon), len(poses) - 1)
        result = solver.command(q, v, poses[ahead])
        return Command(result.velocity, result.stopped)

    return Follower("velocity", command)


def predict_clear_of_world(problem: TrackingProblem) -> Follower:
    """`CartesianMPC` that keeps clear of the world."""
    return predict(problem, avoid=True)


def operational_space(problem: TrackingProblem) -> Follower:
    """`OperationalSpaceQP` in every physics step, with tip pose, twist and acceleration, and the motion's elbow."""
    config = OperationalSpaceConfig(dt=problem.physics_dt, limit_margin=LIMIT_MARGIN)
    solver = OperationalSpaceQP(problem.model_with_payload(), config)
    postures, poses = _configurations(problem, problem.physics_dt), _tip_poses(problem, problem.physics_dt)
    motion = _tip_motion(problem, problem.physics_dt)

    def command(k: int, q: FloatArray, v: FloatArray) -> Command:
        twist, acceleration = _at(motion, k)
        solver.posture = _at(postures, k)
        result = solver.command(q, v, _at(poses, k), twist, acceleration)
        return Command(result.torque, result.stopped)

    return Follower("torque", command)


def joint_impedance(problem: TrackingProblem) -> Follower:
    """`JointImpedance` in every physics step: springs along the motion, with its velocities and accelerations."""
    controller, dt = JointImpedance(problem.model_with_payload(), problem.model.description.joint_stiffness), problem.physics_dt

    def command(k: int, q: FloatArray, v: FloatArray) -> Command:
        return Command(controller.torque(q, v, *problem.trajectory.sample(k * dt)))

    return Follower("torque", command)


def cartesian_impedance(problem: TrackingProblem) -> Follower:
    """`CartesianImpedance` in every physics step: a spring along the tip's motion, and a soft one along the elbow's motion."""
    controller = CartesianImpedance(problem.model_with_payload(), TIP_STIFFNESS, posture_stiffness=ELBOW_STIFFNESS)
    postures, poses = _configurations(problem, problem.physics_dt), _tip_poses(problem, problem.physics_dt)
    motion = _tip_motion(problem, problem.physics_dt)

    def command(k: int, q: FloatArray, v: FloatArray) -> Command:
        controller.posture = _at(postures, k)
        return Command(controller.torque(q, v, _at(poses, k), _at(motion, k)[0]))

    return Follower("torque", command)


def with_safety_filter(inner: Callable[[TrackingProblem], Follower]) -> Callable[[TrackingProblem], Follower]:
    """Return a follower of velocities with a `SafetyFilter` behind it."""

    def build(problem: TrackingProblem) -> Follower:
        follower = inner(problem)
        config = SafetyConfig(dt=problem.control_dt, margin=MARGIN, self_margin=MARGIN, limit_margin=LIMIT_MARGIN)
        guard = SafetyFilter(problem.model, config)
        guard.distances.update(problem.world, problem.touching)

        def command(k: int, q: FloatArray, v: FloatArray) -> Command:
            safe = guard.filter(q, v, follower.command(k, q, v).values)
            return Command(safe.velocity, safe.stopped, safe.intervened)

        return Follower("velocity", command)

    return build


FOLLOWERS: Mapping[str, Callable[[TrackingProblem], Follower]] = {
    "TrajectoryTracker": track_positions,
    "VelocityFollowing": follow_velocities,
    "VelocityFollowing + SafetyFilter": with_safety_filter(follow_velocities),
    "DifferentialIK, poses": follow_poses,
    "DifferentialIK, twists": follow_twists,
    "DifferentialIKQP, twists": follow_twists_by_osqp,
    "DifferentialIK, twists + SafetyFilter": with_safety_filter(follow_twists),
    "CartesianMPC": predict,
    "CartesianMPC, distances": predict_clear_of_world,
    "ComputedTorque": computed_torque,
    "OperationalSpaceQP": operational_space,
    "JointImpedance": joint_impedance,
    "CartesianImpedance": cartesian_impedance,
}
"""Name of a controller -> how to build its follower for one tracking problem."""


def _differential_ik(problem: TrackingProblem) -> DifferentialIK:
    return DifferentialIK(problem.model, DifferentialIKConfig(dt=problem.control_dt), posture=problem.trajectory.q[-1])


def _distances(problem: TrackingProblem) -> DistanceModel:
    distances = DistanceModel(problem.model)
    distances.update(problem.world, problem.touching)
    return distances


def _times(problem: TrackingProblem, dt: float) -> FloatArray:
    """Return 0, dt, 2 dt, ... up to the first tick at or after the end, shape (m,), [s]."""
    return np.asarray(dt * np.arange(int(np.ceil(problem.trajectory.duration / dt - 1e-9)) + 1), dtype=np.float64)


def _configurations(problem: TrackingProblem, dt: float) -> FloatArray:
    """Return the configuration at every tick, shape (m, n), [rad]."""
    return np.array([problem.trajectory.sample(t)[0] for t in _times(problem, dt)])


def _tip_poses(problem: TrackingProblem, dt: float) -> FloatArray:
    """Return the tip pose at every tick, shape (m, 7)."""
    return np.array([problem.model.tip_pose(q) for q in _configurations(problem, dt)])


def _tip_motion(problem: TrackingProblem, dt: float) -> FloatArray:
    """Return twist and acceleration of the tip along world axes at every tick, shape (m, 2, 6); rest at the end."""
    model, motion = problem.model, []
    for t in _times(problem, dt)[:-1]:
        q, v, a = problem.trajectory.sample(t)
        jacobian = model.jacobian(q)
        motion.append((jacobian @ v, jacobian @ a + model.jacobian_dot(q, v) @ v))
    return np.array([*motion, (np.zeros(6), np.zeros(6))])


def _at(rows: FloatArray, k: int) -> FloatArray:
    """Return row `k`, or the last one."""
    return rows[min(k, len(rows) - 1)]
