"""Controllers compared on equal terms: each follows the legs that a demonstration planned, from the same states.

A leg is free when its motion was planned around obstacles, and a contact leg when it may touch: pressing, pushing, pulling
along an arc. On free legs the world stands still but for what the hand holds; on contact legs touching may be the purpose,
and what is pushed away counts where it stood.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from rlbench_pin.environment.demos import DemoPlayer, try_play
from rlbench_pin.environment.motion import REST_SPEED
from rlbench_pin.environment.runtime import Listener, Runtime, RuntimeState
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import DemoError, UnknownName
from rlbench_pin.evaluation.controllers.followers import FOLLOWERS, OVERTIME, Command, Follower, TrackingProblem
from rlbench_pin.planning.plan import Plan
from rlbench_pin.robot.distances import DistanceModel
from rlbench_pin.robot.trajectory import Trajectory
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.sim import World
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks import Waypoint
from rlbench_pin.values import as_names, as_record, as_seed, as_whole

TOUCH = 0.001
"""Pairs nearer than this at the start of a leg do not count as clearance [m]."""
ARRIVED = 0.001
"""Distance of the tip from the end of the leg at which a resting arm has arrived [m]."""
PLAN = "the plan itself"
"""Name of the reference in tables."""


@dataclass(frozen=True, eq=False)
class Leg:
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
class LegTrial:
    """How one controller followed one leg; one number per control tick where not said otherwise."""

    controller: str
    """Name of the controller, or `PLAN`."""
    leg: Leg
    """What was followed."""
    tip_errors: FloatArray
    """Distance of the tip from the reference [m]."""
    joint_errors: FloatArray
    """Largest error of any joint [rad]."""
    overtime: float
    """Time until arrival after the end of the motion, one second at most [s]."""
    violations: Mapping[str, int]
    """Ticks at which joint positions, velocities or accelerations were beyond their limits, by name."""
    touched: tuple[str, ...]
    """Bodies that were touched, but not at the start; on contact legs that may be the purpose."""
    clearance: float
    """Smallest distance to what was not touched at the start, as the world stood then [m]; negative inside of what moved away."""
    interventions: int
    """Commands that a safety filter changed."""
    stops: int
    """Commands that were braking, because the controller found no solution."""
    seconds: FloatArray
    """Processor time of each command, one number per command [s]."""


# Recording legs ------------------------------------------------------------------------------------------------------


class LegRecorder(Listener):
    """Keeps the motion and the starting state of every leg of a demonstration.

    Args:
        task: What demonstrates, after its reset.
    """

    def __init__(self, task: TaskEnvironment) -> None:
        self._runtime, self._name, self._seed = task.runtime, task.get_name(), task.seed
        self.legs: list[Leg] = []

    def on_segment(self, waypoint: Waypoint, plan: Plan) -> None:
        """Keep the leg that is about to begin."""
        free = waypoint.path != "curve" and not waypoint.ignore_collisions
        self.legs.append(Leg(self._name, self._seed, waypoint.index, free, plan.trajectory, self._runtime.save()))


def record_legs(task: TaskEnvironment, seed: int, most: int | None = None) -> list[Leg]:
    """Play the demonstration of a seed and return its legs, the first `most` of them.

    Raises:
        DemoError: The demonstration failed.
        InvalidValue: The seed is none, or `most` no whole number from 1 on.
    """
    as_record(task, TaskEnvironment, "task")
    seed, most = as_seed(seed), None if most is None else as_whole(most, "most", least=1)
    task.reset(seed=seed)
    recorder = LegRecorder(task)
    with task.runtime.listening(recorder):
        cause, _ = try_play(DemoPlayer(task.runtime, record=False))
    if cause:
        raise DemoError(f"The demonstration of '{task.get_name()}' from seed {seed} failed ({cause}). Choose another seed.")
    return recorder.legs[:most]


# Following legs ------------------------------------------------------------------------------------------------------


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


def follow_demo(task: TaskEnvironment, seed: int, controllers: Sequence[str], most: int | None = None) -> Iterator[LegTrial]:
    """Record the legs of one demonstration, the first `most` of them, and let every controller follow each.

    Yields the trial of the plan itself first, then one for each controller, leg by leg.

    Raises:
        DemoError: The demonstration failed.
        UnknownName: A controller does not exist.
    """
    controllers = known_controllers(controllers)
    for leg in record_legs(task, seed, most):
        yield plan_trial(task.runtime, leg)
        yield from (follow_leg(task.runtime, leg, name) for name in controllers)


def follow_leg(runtime: Runtime, leg: Leg, controller: str) -> LegTrial:
    """Go back to the start of a leg and let a controller follow it; the world stays where that ends."""
    (controller,) = known_controllers([controller])
    problem, clearance = _prepare(runtime, leg)
    runner = _Runner(runtime, FOLLOWERS[controller](problem))
    before = set(problem.touching)
    limits, dt = runtime.model.limits, problem.control_dt
    violations = dict.fromkeys(("position", "velocity", "acceleration"), 0)
    tip_errors, joint_errors, nearest, touched = [], [], np.inf, set[str]()
    ticks, rest, v = int(np.ceil(leg.trajectory.duration / dt - 1e-9)), 0.0, runtime.robot.joint_velocities
    with runner.running():
        for k in range(ticks + OVERTIME):
            runner.tick(k)
            q, now, goal = runtime.robot.joint_positions, runtime.robot.joint_velocities, leg.trajectory.sample((k + 1) * dt)[0]
            violations["position"] += not limits.contains(q, 1e-6)
            violations["velocity"] += bool((np.abs(now) > 1.001 * limits.velocity).any())
            violations["acceleration"] += bool((np.abs(now - v) > 1.01 * dt * limits.acceleration).any())
            tip_errors.append(float(np.linalg.norm((runtime.model.tip_pose(q) - runtime.model.tip_pose(goal))[:3])))
            joint_errors.append(float(np.abs(q - goal).max()))
            nearest = min(nearest, clearance(q, nearest))
            touched |= set(runtime.touching()) - before
            v, rest = now, max(0.0, (k + 1) * dt - leg.trajectory.duration)
            if k + 1 >= ticks and np.abs(v).max() < REST_SPEED and tip_errors[-1] < ARRIVED:
                break
    return LegTrial(
        controller, leg, np.array(tip_errors), np.array(joint_errors), rest, violations, tuple(sorted(touched)), nearest,
        sum(c.intervened for c in runner.commands), sum(c.stopped for c in runner.commands), np.array(runner.seconds),
    )  # fmt: skip


def plan_trial(runtime: Runtime, leg: Leg) -> LegTrial:
    """Return what a perfect controller would get: no errors, and the clearance of the planned motion."""
    problem, clearance = _prepare(runtime, leg)
    nearest = np.inf
    for t in np.arange(0.0, leg.trajectory.duration + problem.control_dt, problem.control_dt):
        nearest = min(nearest, clearance(leg.trajectory.sample(float(t))[0], nearest))
    return LegTrial(PLAN, leg, np.zeros(1), np.zeros(1), 0.0, {}, (), nearest, 0, 0, np.zeros(0))


def _prepare(runtime: Runtime, leg: Leg) -> tuple[TrackingProblem, Callable[[FloatArray, float], float]]:
    """Go to the start of a leg; return the problem for its followers, and a function that measures clearance."""
    as_record(runtime, Runtime, "runtime").restore(as_record(leg, Leg, "leg").state)
    world, snapshot = runtime.world, runtime.world.snapshot()
    problem = TrackingProblem(runtime.model, leg.trajectory, snapshot, runtime.touching(), world.control_dt, world.timestep)
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
