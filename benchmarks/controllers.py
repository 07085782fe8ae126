"""Controllers compared on equal terms: each follows the segments that demonstrations planned, from the same states."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass

import numpy as np
import pinocchio as pin
from tqdm import tqdm

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
from rlbench_pin.environment import library_versions, low_dim_config, make_environment
from rlbench_pin.environment.actions.safe_arm import LIMIT_MARGIN
from rlbench_pin.environment.demos import DemoPlayer, try_play
from rlbench_pin.environment.runtime import REST_SPEED, Listener, Runtime, RuntimeState
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import DemoError, UnknownName
from rlbench_pin.planning.plan import Plan
from rlbench_pin.robot.distances import DistanceModel
from rlbench_pin.robot.dynamics import payload_inertia
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.robot.trajectory import Trajectory
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.sim import DriveMode, World
from rlbench_pin.spatial import FloatArray, pose_to_se3, se3_to_pose
from rlbench_pin.tasks import Waypoint, find_task
from rlbench_pin.values import as_names, as_record, as_seed, as_several, as_whole

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
        """Return a model of the arm with the body grasped at the start as payload."""
        model = RobotModel(self.model.description, se3_to_pose(self.model.base))
        model.carry(payload_inertia(self.model, self.world))
        return model


@dataclass(frozen=True, eq=False)
class Command:
    """Command of a controller for the next tick."""

    values: FloatArray
    """Joint positions [rad], velocities [rad/s] or torques [N m], shape (n,)."""
    stopped: bool = False
    """The controller found no solution and brakes."""
    intervened: bool = False
    """A safety filter changed the command."""


@dataclass(frozen=True)
class Follower:
    """A controller with access to the trajectory that it follows."""

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
        safety = SafetyFilter(problem.model, config)
        safety.distances.update(problem.world, problem.touching)

        def command(k: int, q: FloatArray, v: FloatArray) -> Command:
            safe = safety.filter(q, v, follower.command(k, q, v).values)
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


TOUCH = 0.001
"""Pairs nearer than this at the start of a segment do not count as clearance [m]."""
ARRIVED = 0.001
"""Distance of the tip from the end of the segment at which a resting arm has arrived [m]."""
PLAN = "the plan itself"
"""Name of the reference in tables."""


@dataclass(frozen=True, eq=False)
class PlannedSegment:
    """One motion of a demonstration, and the moment at which it begins."""

    task: str
    """Name of the task."""
    seed: int
    """Seed of the episode."""
    waypoint: int
    """Number of the waypoint that it leads to."""
    free: bool
    """Whether the motion was planned around obstacles."""
    trajectory: Trajectory
    """The planned motion."""
    state: RuntimeState
    """The moment at which it begins."""


@dataclass(frozen=True, eq=False)
class SegmentTrial:
    """How one controller followed one segment; one number per control tick where not said otherwise."""

    controller: str
    """Name of the controller, or `PLAN`."""
    segment: PlannedSegment
    """Result of following one trajectory."""
    tip_errors: FloatArray
    """Distance of the tip from the reference [m]."""
    joint_errors: FloatArray
    """Largest error of any joint [rad]."""
    overtime: float
    """Time until arrival after the end of the motion, one second at most [s]."""
    violations: Mapping[str, int]
    """Ticks at which joint positions, velocities or accelerations were beyond their limits, by name."""
    touched: tuple[str, ...]
    """Bodies that were touched, but not at the start; on contact segments that may be the purpose."""
    clearance: float
    """Smallest distance to what was not touched at the start, as the world stood then [m]; negative inside of what moved away."""
    interventions: int
    """Commands that a safety filter changed."""
    stops: int
    """Commands that were braking, because the controller found no solution."""
    seconds: FloatArray
    """Processor time of each command, one number per command [s]."""


# Recording segments ------------------------------------------------------------------------------------------------------


class SegmentRecorder(Listener):
    """Keeps the motion and the starting state of every segment of a demonstration.

    Args:
        task: What demonstrates, after its reset.
    """

    def __init__(self, task: TaskEnvironment) -> None:
        self._runtime, self._name, self._seed = task.runtime, task.get_name(), task.seed
        self.segments: list[PlannedSegment] = []

    def on_segment(self, waypoint: Waypoint, plan: Plan) -> None:
        """Keep the segment that is about to begin."""
        free = waypoint.path != "curve" and not waypoint.ignore_collisions
        self.segments.append(PlannedSegment(self._name, self._seed, waypoint.index, free, plan.trajectory, self._runtime.save()))


def record_segments(task: TaskEnvironment, seed: int, most: int | None = None) -> list[PlannedSegment]:
    """Play the demonstration of a seed and return its segments, the first `most` of them.

    Raises:
        DemoError: The demonstration failed.
        InvalidValue: The seed is none, or `most` no whole number from 1 on.
    """
    as_record(task, TaskEnvironment, "task")
    seed, most = as_seed(seed), None if most is None else as_whole(most, "most", least=1)
    task.reset(seed=seed)
    recorder = SegmentRecorder(task)
    with task.runtime.listening(recorder):
        cause, _ = try_play(DemoPlayer(task.runtime, record=False))
    if cause:
        raise DemoError(f"The demonstration of '{task.get_name()}' from seed {seed} failed ({cause}). Choose another seed.")
    return recorder.segments[:most]


# Following segments ------------------------------------------------------------------------------------------------------


def chosen_controllers(names: Collection[str]) -> tuple[str, ...]:
    """Return `names`, or all when none is given.

    Raises:
        UnknownName: One of them does not exist.
    """
    return known_controllers(names) or tuple(FOLLOWERS)


def known_controllers(names: Collection[str]) -> tuple[str, ...]:
    """Return `names`, or raise UnknownName."""
    names = as_names(names, "controllers")
    for name in names:
        if name not in FOLLOWERS:
            raise UnknownName("controller", name, tuple(FOLLOWERS))
    return names


def follow_demo(task: TaskEnvironment, seed: int, controllers: Sequence[str], most: int | None = None) -> Iterator[SegmentTrial]:
    """Record the segments of one demonstration, the first `most` of them, and let every controller follow each.

    Yields the trial of the plan itself first, then one for each controller, segment by segment.

    Raises:
        DemoError: The demonstration failed.
        UnknownName: A controller does not exist.
    """
    controllers = known_controllers(controllers)
    for segment in record_segments(task, seed, most):
        yield plan_trial(task.runtime, segment)
        yield from (follow_segment(task.runtime, segment, name) for name in controllers)


def follow_segment(runtime: Runtime, segment: PlannedSegment, controller: str) -> SegmentTrial:
    """Go back to the start of a segment and let a controller follow it; the world stays where that ends."""
    (controller,) = known_controllers([controller])
    problem, clearance = _prepare(runtime, segment)
    runner = _Runner(runtime, FOLLOWERS[controller](problem))
    before = set(problem.touching)
    limits, dt = runtime.model.limits, problem.control_dt
    violations = dict.fromkeys(("position", "velocity", "acceleration"), 0)
    tip_errors, joint_errors, nearest, touched = [], [], np.inf, set[str]()
    ticks, rest, v = int(np.ceil(segment.trajectory.duration / dt - 1e-9)), 0.0, runtime.robot.joint_velocities
    with runner.running():
        for k in range(ticks + OVERTIME):
            runner.tick(k)
            q, now, goal = (
                runtime.robot.joint_positions,
                runtime.robot.joint_velocities,
                segment.trajectory.sample((k + 1) * dt)[0],
            )
            violations["position"] += not limits.contains(q, 1e-6)
            violations["velocity"] += bool((np.abs(now) > 1.001 * limits.velocity).any())
            violations["acceleration"] += bool((np.abs(now - v) > 1.01 * dt * limits.acceleration).any())
            tip_errors.append(float(np.linalg.norm((runtime.model.tip_pose(q) - runtime.model.tip_pose(goal))[:3])))
            joint_errors.append(float(np.abs(q - goal).max()))
            nearest = min(nearest, clearance(q, nearest))
            touched |= set(runtime.touching()) - before
            v, rest = now, max(0.0, (k + 1) * dt - segment.trajectory.duration)
            if k + 1 >= ticks and np.abs(v).max() < REST_SPEED and tip_errors[-1] < ARRIVED:
                break
    return SegmentTrial(
        controller, segment, np.array(tip_errors), np.array(joint_errors), rest, violations, tuple(sorted(touched)), nearest,
        sum(c.intervened for c in runner.commands), sum(c.stopped for c in runner.commands), np.array(runner.seconds),
    )  # fmt: skip


def plan_trial(runtime: Runtime, segment: PlannedSegment) -> SegmentTrial:
    """Return what a perfect controller would get: no errors, and the clearance of the planned motion."""
    problem, clearance = _prepare(runtime, segment)
    nearest = np.inf
    for t in np.arange(0.0, segment.trajectory.duration + problem.control_dt, problem.control_dt):
        nearest = min(nearest, clearance(segment.trajectory.sample(float(t))[0], nearest))
    return SegmentTrial(PLAN, segment, np.zeros(1), np.zeros(1), 0.0, {}, (), nearest, 0, 0, np.zeros(0))


def _prepare(runtime: Runtime, segment: PlannedSegment) -> tuple[TrackingProblem, Callable[[FloatArray, float], float]]:
    """Go to the start of a segment; return the problem for its followers, and a function that measures clearance."""
    as_record(runtime, Runtime, "runtime").restore(as_record(segment, PlannedSegment, "segment").state)
    world, snapshot = runtime.world, runtime.world.snapshot()
    problem = TrackingProblem(runtime.model, segment.trajectory, snapshot, runtime.touching(), world.control_dt, world.timestep)
    return problem, _clearance_function(runtime, snapshot)


def _clearance_function(runtime: Runtime, snapshot: WorldSnapshot) -> Callable[[FloatArray, float], float]:
    """Return a function: configuration, distance that matters at most [m] -> smallest distance to the world, or that."""
    distances = DistanceModel(runtime.model)
    distances.update(snapshot)
    counts = distances.counts & distances.crosses
    which = np.flatnonzero(counts)
    counts[which[distances.measure(which) < TOUCH]] = False

    def clearance(q: FloatArray, most: float) -> float:
        distances.place(q)
        near = np.flatnonzero(counts & (distances.bounds < most))
        return min(most, float(distances.measure(near).min(initial=np.inf)))

    return clearance


class _Runner:
    """Asks a follower for commands, times it, and steps the world."""

    def __init__(self, runtime: Runtime, follower: Follower) -> None:
        self.runtime, self.follower = runtime, follower
        self.commands: list[Command] = []
        self.seconds: list[float] = []

    @contextmanager
    def running(self) -> Iterator[None]:
        """Command torques in every physics step, when the follower wants that; rest afterwards."""
        if self.follower.mode != "torque":
            yield
            return
        self.runtime.robot.set_torques(np.zeros(self.runtime.model.size))
        with _before_physics(self.runtime.world, self._command_torques):
            yield
        self.runtime.hold()

    def tick(self, k: int) -> None:
        """Run control tick `k`."""
        robot, mode = self.runtime.robot, self.follower.mode
        if mode == "position":
            self.runtime.drive_to(self._ask(k))
            return
        if mode == "velocity":
            robot.set_velocity_targets(self._ask(k))
        self.runtime.step()

    def _command_torques(self) -> None:
        self.runtime.robot.forget_measurements()
        self.runtime.robot.set_torques(self._ask(len(self.commands)))

    def _ask(self, k: int) -> FloatArray:
        q, v = self.runtime.robot.joint_positions, self.runtime.robot.joint_velocities
        began = time.process_time()
        command = self.follower.command(k, q, v)
        self.seconds.append(time.process_time() - began)
        self.commands.append(command)
        return command.values


@contextmanager
def _before_physics(world: World, command: Callable[[], None]) -> Iterator[None]:
    world.on_physics.append(command)
    try:
        yield
    finally:
        world.on_physics.remove(command)


@dataclass(frozen=True)
class ControllerSummary:
    """How one controller followed the segments of one kind."""

    controller: str
    """Name of the controller, or `PLAN`."""
    kind: str
    """`free` or `contact`."""
    segments: int
    """Segments that it followed."""
    tip_median_mm: float
    """Median distance of the tip from the reference [mm]."""
    tip_max_mm: float
    """Largest distance of the tip from the reference [mm]."""
    joint_median_mrad: float
    """Median of the largest joint error [mrad]."""
    joint_max_mrad: float
    """Largest joint error [mrad]."""
    end_max_mm: float
    """Largest error of the tip at the end of a segment, a second for arriving included."""
    overtime_median_s: float
    """Time until arrival (at rest within 1 mm) after the planned end, median, a second at most [s]."""
    overtime_max_s: float
    """Longest time until arrival [s]."""
    violations: dict[str, int]
    """Ticks beyond the limits of joint position, velocity, acceleration."""
    ticks: int
    """Control ticks in all."""
    touched: int
    """Segments on which something was touched that was not touched at the start."""
    clearance_mm: float | None
    """Smallest distance to the world as it stood at the start of a segment; None where nothing is near [mm]."""
    interventions: float
    """Share of commands that a safety filter changed."""
    stops: float
    """Share of commands that were braking, because the controller found no solution."""
    median_us: float
    """Median cost of a command [us]."""
    p99_us: float
    """99th percentile of the cost of a command [us]."""


def summarise_segments(trials: Sequence[SegmentTrial]) -> list[ControllerSummary]:
    """Return one summary per controller and kind of segment, free segments first, controllers in the order they came."""
    for trial in as_several(trials, "trials"):
        as_record(trial, SegmentTrial, "A trial")
    names = tuple(dict.fromkeys(t.controller for t in trials))
    groups = [
        (name, free, [t for t in trials if t.controller == name and t.segment.free == free])
        for free in (True, False)
        for name in names
    ]
    return [_summary(name, "free" if free else "contact", group) for name, free, group in groups if group]


def _summary(name: str, kind: str, trials: Sequence[SegmentTrial]) -> ControllerSummary:
    tip, joint = (np.concatenate([getattr(t, key) for t in trials]) for key in ("tip_errors", "joint_errors"))
    seconds = np.concatenate([t.seconds for t in trials])
    nearest, overtimes, commands = min(t.clearance for t in trials), [t.overtime for t in trials], max(1, len(seconds))
    median, p99 = np.percentile(seconds, (50, 99)) if len(seconds) else (0.0, 0.0)
    return ControllerSummary(
        controller=name,
        kind=kind,
        segments=len(trials),
        tip_median_mm=_thousandths(np.median(tip)),
        tip_max_mm=_thousandths(tip.max()),
        joint_median_mrad=_thousandths(np.median(joint)),
        joint_max_mrad=_thousandths(joint.max()),
        end_max_mm=_thousandths(max(t.tip_errors[-1] for t in trials)),
        overtime_median_s=round(float(np.median(overtimes)), 3),
        overtime_max_s=round(max(overtimes), 3),
        violations={key: sum(t.violations[key] for t in trials) for key in trials[0].violations},
        ticks=0 if name == PLAN else len(tip),
        touched=sum(bool(t.touched) for t in trials),
        clearance_mm=_thousandths(nearest) if math.isfinite(nearest) else None,
        interventions=round(sum(t.interventions for t in trials) / commands, 4),
        stops=round(sum(t.stops for t in trials) / commands, 4),
        median_us=round(1e6 * float(median), 1),
        p99_us=round(1e6 * float(p99), 1),
    )


def _thousandths(value: float) -> float:
    return round(1e3 * float(value), 3)


HEADER = (
    "controller", "segments", "tip mm", "joint mrad", "end mm", "overtime s", "violations",
    "touched", "clearance mm", "filtered", "stops", "us", "p99 us",
)  # fmt: skip


def table(summaries: Sequence[ControllerSummary]) -> str:
    """Return a Markdown table of summaries; errors as median / maximum, violations as position / velocity / acceleration."""
    for summary in as_several(summaries, "summaries"):
        as_record(summary, ControllerSummary, "A summary")
    rows = [HEADER, *map(_row, summaries)]
    widths = [max(map(len, column)) for column in zip(*rows)]
    rows.insert(1, tuple("-" * width for width in widths))
    return "\n".join("| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths)) + " |" for row in rows)


def _row(s: ControllerSummary) -> tuple[str, ...]:
    clearance = "" if s.clearance_mm is None else f"{s.clearance_mm:.1f}"
    if s.controller == PLAN:
        return (s.controller, str(s.segments), *[""] * 6, clearance, *[""] * 4)
    return (
        s.controller,
        str(s.segments),
        f"{s.tip_median_mm:.2f} / {s.tip_max_mm:.1f}",
        f"{s.joint_median_mrad:.2f} / {s.joint_max_mrad:.1f}",
        f"{s.end_max_mm:.2f}",
        f"{s.overtime_median_s:.2f} / {s.overtime_max_s:.2f}",
        " / ".join(str(count) for count in s.violations.values()),
        str(s.touched),
        clearance,
        f"{s.interventions:.1%}",
        f"{s.stops:.1%}",
        f"{s.median_us:.0f}",
        f"{s.p99_us:.0f}",
    )


@dataclass(frozen=True)
class ControllerComparison:
    """Controllers on the segments of demonstrations."""

    tasks: tuple[str, ...]
    """Task names, or task files."""
    episodes: int = 1
    """Demonstrations of each task."""
    seed: int = 0
    """Seed of the first episode; episode i uses seed + i."""
    segments: int | None = None
    """Number of segments of each demonstration; all when None."""
    only: tuple[str, ...] = ()
    """Controllers to compare; all when none is given."""

    def content(self, summaries: Sequence[ControllerSummary]) -> dict[str, object]:
        """Return what the JSON file says."""
        return {
            "format": 1,
            "tasks": list(self.tasks),
            "episodes": self.episodes,
            "seed": self.seed,
            "segments": self.segments,
            "versions": library_versions(),
            "controllers": [asdict(s) for s in summaries],
        }

    def trials(self) -> Iterator[SegmentTrial]:
        """Let every controller follow every segment."""
        names = chosen_controllers(self.only)
        classes = [find_task(name) for name in self.tasks]
        with tqdm(total=len(classes) * self.episodes, unit="episode", desc="controllers") as bar:
            for task_class in classes:
                with make_environment(low_dim_config()) as environment:
                    task = environment.get_task(task_class)
                    for seed in range(self.seed, self.seed + self.episodes):
                        yield from follow_demo(task, seed, names, self.segments)
                        bar.update()


def report(summaries: Sequence[ControllerSummary], title: str = "") -> str:
    """Return one table per kind of segment under its heading; `title` stands before each heading."""
    headings = {"free": "Segments planned around obstacles", "contact": "Segments that may touch"}
    parts = [(heading, [s for s in summaries if s.kind == kind]) for kind, heading in headings.items()]
    return "\n\n".join(f"{title}{heading}\n\n{table(rows)}" for heading, rows in parts if rows)
