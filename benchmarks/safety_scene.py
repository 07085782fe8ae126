"""The arm behind its safety filter under random velocities and gripper commands in one scene, every tick of it measured."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from harness import state_only

from rlbench_pin.control import SafeCommand, SafetyConfig
from rlbench_pin.environment import Discrete, Environment, JointVelocity, MoveArmThenGripper, SafeArm, TaskEnvironment
from rlbench_pin.environment.actions.safe_arm import LIMIT_MARGIN, RuntimeFilter, wanted_velocity
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.robot.distances import DistanceModel
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.spatial import FloatArray

CONFIG = SafetyConfig(limit_margin=LIMIT_MARGIN)
EPISODE = 204
"""Actions of the arm in an episode, a multiple of all holdings."""
GRIPPER_CHANGES = 1 / 12
"""Probability that an action opens a shut gripper, or shuts an open one."""
SLACK = 0.001
"""How much below its margin a distance may be [m]."""
TREMBLE = 1e-6
"""Moves of fingers and bodies that the checker ignores [m], and parts of quaternions."""
KINDS = ("position", "velocity", "acceleration", "contact", "distance")
State = tuple[FloatArray, FloatArray, FloatArray]


@dataclass
class Figures:
    """Measurements of one scene."""

    actions: int = 0
    ticks: int = 0
    position: int = 0
    velocity: int = 0
    acceleration: int = 0
    """Ticks at which a joint was beyond its limit of this kind."""
    contact: int = 0
    """Ticks at which the arm touched something, other than bodies between the fingers."""
    distance: int = 0
    """Ticks at which a distance was below its margin by more than the slack, other than to bodies between the fingers."""
    openings: int = 0
    """Commands to open a shut gripper."""
    refused: int = 0
    """Those that were refused for want of room."""
    gripping: int = 0
    """Ticks at which a body was between the fingers."""
    nearest_world_m: float = np.inf
    nearest_self_m: float = np.inf
    hardest: float = 0.0
    """Largest acceleration of a joint, as a share of its limit."""
    clipped: int = 0
    """Commands changed for the sake of joint limits or torques alone: a random velocity asks for more than motors can do."""
    avoided: int = 0
    """Commands changed for the sake of distances."""
    stops: int = 0
    """Commands that were the hardest braking, for want of anything better."""
    tick_us: dict[str, float] = field(default_factory=dict)
    """Processor time of the filter by itself, on the states of the last episode."""
    loop_tick_us: dict[str, float] = field(default_factory=dict)
    """And of the filter as it ran, between steps of physics, taking over a world that moved included."""
    events: list[str] = field(default_factory=list)
    """Violations with place and time, in words."""

    def violations(self) -> int:
        """Return ticks with a violation, of all kinds."""
        return self.position + self.velocity + self.acceleration + self.contact + self.distance


def merged(parts: Sequence[Figures]) -> Figures:
    """Return the figures of several runs in one: sums, extremes, and medians of the times."""
    total: dict[str, Any] = {}
    for f in fields(Figures):
        values = [getattr(part, f.name) for part in parts]
        if isinstance(values[0], dict):
            total[f.name] = {key: round(float(np.median([v[key] for v in values])), 1) for key in values[0]}
        elif f.name.startswith("nearest"):
            total[f.name] = min(values)
        elif f.name == "hardest":
            total[f.name] = max(values)
        else:
            total[f.name] = sum(values, start=type(values[0])())
    return Figures(**total)


@dataclass
class TimedFilter(RuntimeFilter):
    """A filter that notes what it takes to take over the world [s]."""

    update_seconds: list[float] = field(default_factory=list)

    def update_world(self, snapshot: WorldSnapshot) -> None:
        """Give the filter the world."""
        began = time.process_time()
        super().update_world(snapshot)
        self.update_seconds.append(time.process_time() - began)


class TimedArm(SafeArm):
    """Keeps the states that the filter saw in the last episode, and what each tick of it took, world included [s]."""

    def __init__(self) -> None:
        super().__init__(JointVelocity(), CONFIG)
        self.states: list[State] = []
        self.seconds: list[float] = []

    def make_filter(self, runtime: Runtime) -> RuntimeFilter:
        """Make the filter, timed."""
        return TimedFilter(super().make_filter(runtime).filter)

    def filter_command(self, runtime: Runtime, runtime_filter: RuntimeFilter) -> SafeCommand:
        q, v = runtime.robot.joint_positions, runtime.robot.joint_velocities
        self.states.append((q, v, wanted_velocity(runtime, q, v).copy()))
        began = time.process_time()
        command = super().filter_command(runtime, runtime_filter)
        self.seconds.append(time.process_time() - began + runtime_filter.update_seconds[-1])
        return command

    def alone(self, runtime: Runtime) -> list[float]:
        """Filter the states again, and nothing else; return the processor time of each [s]."""
        runtime_filter = self.filter_of(runtime).filter
        seconds = []
        for state in self.states:
            began = time.process_time()
            runtime_filter.filter(*state)
            seconds.append(time.process_time() - began)
        return seconds


class Checker:
    """Measures the simulated arm after every tick."""

    def __init__(self, task: TaskEnvironment) -> None:
        self.task, self.limits, self.dt = task, task.runtime.model.limits, task.world.control_dt
        self.distances = DistanceModel(task.runtime.model)
        self.figures = Figures()
        self._seen, self._between = np.zeros(0), list[str]()

    def begin(self, episode: str) -> None:
        """Begin an episode, which is named in what is reported."""
        self.v, self.tick, self.episode = self.task.world.robot.joint_velocities, 0, episode

    def measure(self, arm: SafeArm) -> None:
        """Measure one tick."""
        f, robot, limits = self.figures, self.task.world.robot, self.limits
        q, v = robot.joint_positions, robot.joint_velocities
        hardest = float((np.abs(v - self.v) / self.dt / limits.acceleration).max())
        outside = bool((q < limits.lower - 1e-6).any() or (q > limits.upper + 1e-6).any())
        fast = bool((np.abs(v) > limits.velocity * 1.001).any())
        snapshot, gripper = self.task.world.snapshot(), self.task.world.gripper
        between = [body.name for body in snapshot.bodies if body.collides and gripper.reaches_between_fingers(body.name)]
        f.gripping += bool(between)
        touched = not set(robot.touching()) <= set(between)
        broken = (outside, fast, hardest > 1.01, touched, self._too_near(q, snapshot, between))
        f.position, f.velocity, f.acceleration = f.position + broken[0], f.velocity + broken[1], f.acceleration + broken[2]
        f.contact, f.distance = f.contact + broken[3], f.distance + broken[4]
        state = f"q {q.tolist()}, v {v.tolist()}, before {self.v.tolist()}"
        f.events += [f"{self.episode}, tick {self.tick}: {kind}, {state}" for kind, found in zip(KINDS, broken) if found]
        f.ticks, f.hardest, self.v, self.tick = f.ticks + 1, max(f.hardest, hardest), v, self.tick + 1
        reasons = set(arm.last.reasons) if arm.last is not None else set()
        f.clipped += bool(reasons) and reasons <= {"limits", "torque"}
        f.avoided += bool(reasons - {"limits", "torque"})
        f.stops += arm.last is not None and arm.last.stopped

    def _take_over(self, snapshot: WorldSnapshot, between: list[str]) -> None:
        """Take over the world, when anything but the arm moved since by more than `TREMBLE`."""
        now = np.concatenate([snapshot.fingers, *(body.link_poses.ravel() for body in snapshot.bodies)])
        moved = self._seen.shape != now.shape or np.abs(now - self._seen).max() > TREMBLE
        if moved or between != self._between or snapshot.attached:
            self.distances.update(snapshot, [name for name in between if name not in snapshot.attached])
            self._seen, self._between = now, between

    def _too_near(self, q: FloatArray, snapshot: WorldSnapshot, between: list[str]) -> bool:
        """Measure the distances that can be the smallest so far or too small, with the arm at `q` [rad]; say whether one is."""
        f, model = self.figures, self.distances
        self._take_over(snapshot, between)
        model.place(q)
        least = np.where(model.crosses, max(f.nearest_world_m, CONFIG.margin), max(f.nearest_self_m, CONFIG.self_margin))
        near = np.flatnonzero(model.counts & (model.bounds < least))  # bounds from below
        distances, world = model.measure(near), model.crosses[near]
        to_world, to_self = distances[world].min(initial=np.inf), distances[~world].min(initial=np.inf)
        f.nearest_world_m, f.nearest_self_m = min(f.nearest_world_m, to_world), min(f.nearest_self_m, to_self)
        return bool(to_world < CONFIG.margin - SLACK or to_self < CONFIG.self_margin - SLACK)


def measure_scene(name: str, ticks: int, hold: int, rng: np.random.Generator, first: int = 0) -> Figures:
    """Play random joint velocities of full range, and random gripper commands, in the scene of one task.

    Args:
        name: The task.
        ticks: How many for the arm, `EPISODE` in each episode; the fingers take more.
        hold: Ticks for which an action is kept.
        rng: Draws the actions.
        first: Seed of the first episode; each has the next one.
    """
    arm = TimedArm()
    mode = MoveArmThenGripper(arm, Discrete())
    with Environment(mode, obs_config=state_only(), seed=0) as env:
        task = env.get_task(name)
        checker, fastest = Checker(task), task.runtime.model.limits.velocity
        for tick in range(ticks):
            if tick % EPISODE == 0:
                seed = first + tick // EPISODE
                arm.states.clear()
                task.reset(seed=seed)
                checker.begin(f"{name}, held {hold}, seed {seed}")
                opened = True
            if tick % EPISODE % hold == 0:
                opened ^= bool(rng.random() < GRIPPER_CHANGES)
                action = np.append(rng.uniform(-fastest, fastest), float(opened))
                checker.figures.actions += 1
            opens = opened and not task.world.gripper.is_open
            with task.runtime.acting() as result, task.runtime.calling(after=lambda: checker.measure(arm)):
                mode.action(task.runtime, action)  # a step without observation
            checker.figures.openings += opens
            checker.figures.refused += result.refused_opening is not None
        checker.figures.loop_tick_us, checker.figures.tick_us = _percentiles(arm.seconds), _percentiles(arm.alone(task.runtime))
    return checker.figures


def _percentiles(seconds: Sequence[float]) -> dict[str, float]:
    return {name: round(1e6 * float(np.percentile(seconds, p)), 1) for name, p in (("median", 50), ("p95", 95), ("p99", 99))}
