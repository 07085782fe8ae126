"""Every controller as a follower of one and the same joint motion, so that they can be compared.

What a controller needs of the motion (tip poses, twists, accelerations) is worked out beforehand: a tick costs what the
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
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.robot.payload import payload_inertia
from rlbench_pin.robot.trajectory import Trajectory
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.sim.arm.robot import Mode
from rlbench_pin.spatial import FloatArray, pose_to_se3, se3_to_pose

MARGIN = 0.003
"""Distance to the world that filters and predictions keep [m]: little, because planned motions come near what they grasp."""
TIP_STIFFNESS = (3000.0, 3000.0, 3000.0, 150.0, 150.0, 150.0)
"""[N/m, N m/rad]: the spring of Cartesian impedance control."""
ELBOW_STIFFNESS = 10.0
"""[N m/rad]: its spring on what the tip leaves free."""
OVERTIME = 20
"""Control ticks that a controller may take to arrive after the end of the motion."""


@dataclass(frozen=True, eq=False)
class Errand:
    """One motion to follow, and all that a controller may know of it."""

    model: RobotModel
    trajectory: Trajectory
    world: WorldSnapshot
    touching: Collection[str]
    """Bodies that the arm touches at the start."""
    control_dt: float
    """[s]"""
    physics_dt: float
    """[s]"""

    def loaded(self) -> RobotModel:
        """Return a model of the arm that carries what the hand holds at the start."""
        model = RobotModel(self.model.description, se3_to_pose(self.model.base))
        model.carry(payload_inertia(self.model, self.world))
        return model


@dataclass(frozen=True, eq=False)
class Command:
    """What the motors are told for the next tick."""

    values: FloatArray
    """Joint positions [rad], velocities [rad/s] or torques [N m], shape (n,)."""
    stopped: bool = False
    """The controller found nothing better than braking."""
    intervened: bool = False
    """A safety filter changed the command."""


@dataclass(frozen=True)
class Follower:
    """A controller that knows its motion."""

    mode: Mode
    """What its commands are; torques are commanded in every physics step, all else once per control tick."""
    command: Callable[[int, FloatArray, FloatArray], Command]
    """Command of tick k in state q [rad], v [rad/s]."""


def track_positions(errand: Errand) -> Follower:
    """Position targets, one tick ahead, as demonstrations do."""
    goals = _configurations(errand, errand.control_dt)
    return Follower("position", lambda k, q, v: Command(goals[min(k + 1, len(goals) - 1)]))


def follow_velocities(errand: Errand) -> Follower:
    """`VelocityFollowing`: the reference's velocity and a share of the error."""
    backend = VelocityFollowing(errand.model.limits, errand.control_dt)
    return Follower("velocity", lambda k, q, v: Command(backend.command(errand.trajectory, k * backend.dt, q, v)))


def compute_torques(errand: Errand) -> Follower:
    """`ComputedTorque` in every physics step."""
    backend = ComputedTorque(errand.loaded(), errand.physics_dt)
    return Follower("torque", lambda k, q, v: Command(backend.command(errand.trajectory, k * backend.dt, q, v)))


def chase_poses(errand: Errand) -> Follower:
    """`DifferentialIK` towards the tip pose one tick ahead; it brakes for each as if it were the last."""
    solver, poses = _differential_ik(errand), _tip_poses(errand, errand.control_dt)
    return Follower("velocity", lambda k, q, v: Command(solver.velocity_to_pose(q, v, _at(poses, k + 1))))


def follow_twists(errand: Errand) -> Follower:
    """`DifferentialIK` with the tip velocity that reaches the pose one tick ahead."""
    return _twists(errand, _differential_ik(errand))


def follow_twists_written_out(errand: Errand) -> Follower:
    """`DifferentialIKQP`, the same problem by OSQP."""
    config = DifferentialIKConfig(dt=errand.control_dt)
    return _twists(errand, DifferentialIKQP(errand.model, config, posture=errand.trajectory.q[-1]))


def _twists(errand: Errand, solver: DifferentialIK | DifferentialIKQP) -> Follower:
    poses = _tip_poses(errand, errand.control_dt)

    def command(k: int, q: FloatArray, v: FloatArray) -> Command:
        here, goal = errand.model.tip_se3(q), pose_to_se3(_at(poses, k + 1))
        turn = pin.log3(goal.rotation @ here.rotation.T)
        twist = np.concatenate([goal.translation - here.translation, turn]) / errand.control_dt
        return Command(solver.velocity_for_twist(q, v, twist))

    return Follower("velocity", command)


def predict(errand: Errand, heed: bool = False) -> Follower:
    """`CartesianMPC` on the tip poses of the next ticks."""
    distances = _distances(errand) if heed else None
    config = PredictiveConfig(dt=errand.control_dt, margin=MARGIN, self_margin=MARGIN)
    solver = CartesianMPC(errand.model, config, distances=distances, posture=errand.trajectory.q[-1])
    poses = _tip_poses(errand, errand.control_dt)

    def command(k: int, q: FloatArray, v: FloatArray) -> Command:
        ahead = np.minimum(np.arange(k + 1, k + 1 + config.horizon), len(poses) - 1)
        result = solver.command(q, v, poses[ahead])
        return Command(result.velocity, result.stopped)

    return Follower("velocity", command)


def predict_with_distances(errand: Errand) -> Follower:
    """`CartesianMPC` that keeps clear of the world."""
    return predict(errand, heed=True)


def accelerate_tip(errand: Errand) -> Follower:
    """`OperationalSpaceQP` in every physics step, with tip pose, twist and acceleration, and the motion's elbow."""
    config = OperationalSpaceConfig(dt=errand.physics_dt, limit_margin=LIMIT_MARGIN)
    solver = OperationalSpaceQP(errand.loaded(), config)
    postures, poses = _configurations(errand, errand.physics_dt), _tip_poses(errand, errand.physics_dt)
    motion = _tip_motion(errand, errand.physics_dt)

    def command(k: int, q: FloatArray, v: FloatArray) -> Command:
        twist, acceleration = _at(motion, k)
        solver.posture = _at(postures, k)
        result = solver.command(q, v, _at(poses, k), twist, acceleration)
        return Command(result.torque, result.stopped)

    return Follower("torque", command)


def hold_joints(errand: Errand) -> Follower:
    """`JointImpedance` in every physics step: springs along the motion, with its velocities and accelerations."""
    controller, dt = JointImpedance(errand.loaded(), errand.model.description.joint_stiffness), errand.physics_dt

    def command(k: int, q: FloatArray, v: FloatArray) -> Command:
        return Command(controller.torque(q, v, *errand.trajectory.sample(k * dt)))

    return Follower("torque", command)


def hold_tip(errand: Errand) -> Follower:
    """`CartesianImpedance` in every physics step: a spring along the tip's motion, and a soft one along the elbow's."""
    controller = CartesianImpedance(errand.loaded(), TIP_STIFFNESS, posture_stiffness=ELBOW_STIFFNESS)
    postures, poses = _configurations(errand, errand.physics_dt), _tip_poses(errand, errand.physics_dt)
    motion = _tip_motion(errand, errand.physics_dt)

    def command(k: int, q: FloatArray, v: FloatArray) -> Command:
        controller.posture = _at(postures, k)
        return Command(controller.torque(q, v, _at(poses, k), _at(motion, k)[0]))

    return Follower("torque", command)


def made_safe(inner: Callable[[Errand], Follower]) -> Callable[[Errand], Follower]:
    """Put a `SafetyFilter` behind a controller of velocities."""

    def build(errand: Errand) -> Follower:
        follower = inner(errand)
        config = SafetyConfig(dt=errand.control_dt, margin=MARGIN, self_margin=MARGIN, limit_margin=LIMIT_MARGIN)
        guard = SafetyFilter(errand.model, config)
        guard.distances.update(errand.world, errand.touching)

        def command(k: int, q: FloatArray, v: FloatArray) -> Command:
            safe = guard.filter(q, v, follower.command(k, q, v).values)
            return Command(safe.velocity, safe.stopped, safe.intervened)

        return Follower("velocity", command)

    return build


FOLLOWERS: Mapping[str, Callable[[Errand], Follower]] = {
    "TrajectoryTracker": track_positions,
    "VelocityFollowing": follow_velocities,
    "VelocityFollowing + SafetyFilter": made_safe(follow_velocities),
    "DifferentialIK, poses": chase_poses,
    "DifferentialIK, twists": follow_twists,
    "DifferentialIKQP, twists": follow_twists_written_out,
    "DifferentialIK, twists + SafetyFilter": made_safe(follow_twists),
    "CartesianMPC": predict,
    "CartesianMPC, distances": predict_with_distances,
    "ComputedTorque": compute_torques,
    "OperationalSpaceQP": accelerate_tip,
    "JointImpedance": hold_joints,
    "CartesianImpedance": hold_tip,
}
"""Name -> how to build it for one motion."""


def _differential_ik(errand: Errand) -> DifferentialIK:
    return DifferentialIK(errand.model, DifferentialIKConfig(dt=errand.control_dt), posture=errand.trajectory.q[-1])


def _distances(errand: Errand) -> DistanceModel:
    distances = DistanceModel(errand.model)
    distances.update(errand.world, errand.touching)
    return distances


def _times(errand: Errand, dt: float) -> FloatArray:
    """Return 0, dt, 2 dt, ... up to the first tick at or after the end, shape (m,), [s]."""
    return np.asarray(dt * np.arange(int(np.ceil(errand.trajectory.duration / dt - 1e-9)) + 1), dtype=np.float64)


def _configurations(errand: Errand, dt: float) -> FloatArray:
    """Return the configuration at every tick, shape (m, n), [rad]."""
    return np.array([errand.trajectory.sample(t)[0] for t in _times(errand, dt)])


def _tip_poses(errand: Errand, dt: float) -> FloatArray:
    """Return the tip pose at every tick, shape (m, 7)."""
    return np.array([errand.model.tip_pose(q) for q in _configurations(errand, dt)])


def _tip_motion(errand: Errand, dt: float) -> FloatArray:
    """Return twist and acceleration of the tip along world axes at every tick, shape (m, 2, 6); rest at the end."""
    model, motion = errand.model, []
    for t in _times(errand, dt)[:-1]:
        q, v, a = errand.trajectory.sample(t)
        jacobian = model.jacobian(q)
        motion.append((jacobian @ v, jacobian @ a + model.jacobian_dot(q, v) @ v))
    return np.array([*motion, (np.zeros(6), np.zeros(6))])


def _at(rows: FloatArray, k: int) -> FloatArray:
    """Return row `k`, or the last one."""
    return rows[min(k, len(rows) - 1)]
