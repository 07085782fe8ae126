"""Random joint velocities of full range through the safety filter, in simulated task scenes: what is violated, and what it costs.

Usage: python benchmarks/bench_safety.py [--actions 200000] [--held 20000] [--tasks NAME ...] [--out docs/results]
Writes safety.json and safety.md. Every tick is measured: joint positions, velocities and accelerations against their limits,
contacts of the arm in the simulator, and the smallest distances to the world and within the arm, each against its own margin.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
from harness import Result
from safety_report import report

from rlbench_pin.control.safety_filter import SafetyConfig, SafetyFilter
from rlbench_pin.environment import (
    Discrete,
    Environment,
    JointVelocity,
    MoveArmThenGripper,
    ObservationConfig,
    SafeArm,
    TaskEnvironment,
)
from rlbench_pin.environment.actions.safe_arm import LIMIT_MARGIN, wanted_velocity
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.robot.distances import DistanceModel
from rlbench_pin.spatial import FloatArray

TASKS = (
    "reach_target", "push_button", "pick_and_lift", "take_lid_off_saucepan", "open_drawer",
    "close_microwave", "slide_block_to_target", "stack_blocks", "put_rubbish_in_bin", "meat_off_grill",
)  # fmt: skip
CONFIG = SafetyConfig(limit_margin=LIMIT_MARGIN)
EPISODE = 200
HOLD = 12
"""Ticks for which the second policy keeps an action: long enough for full speed."""
SLACK = 0.001
"""How much below its margin a distance may be [m]."""
State = tuple[FloatArray, FloatArray, FloatArray]


@dataclass
class Figures:
    """What was measured in one scene."""

    actions: int = 0
    position: int = 0
    velocity: int = 0
    acceleration: int = 0
    """Ticks at which a joint was beyond its limit of this kind."""
    contact: int = 0
    """Ticks at which the arm touched something."""
    distance: int = 0
    """Ticks at which a distance was below its margin by more than the slack."""
    nearest_world_m: float = np.inf
    nearest_self_m: float = np.inf
    clipped: int = 0
    """Commands changed for the sake of joint limits alone: a random velocity asks for more than any motor can accelerate."""
    avoided: int = 0
    """Commands changed for the sake of distances."""
    stops: int = 0
    """Commands that were the hardest braking, for want of anything better."""
    tick_us: dict[str, float] = field(default_factory=dict)
    """Processor time of the filter by itself, on the states of the last episode."""
    loop_tick_us: dict[str, float] = field(default_factory=dict)
    """And of the filter as it ran, between steps of physics."""

    def violations(self) -> int:
        """Return ticks with a violation, of all kinds."""
        return self.position + self.velocity + self.acceleration + self.contact + self.distance


class TimedArm(SafeArm):
    """Keeps the states that the filter saw in the last episode, and what each call took [s]."""

    def __init__(self) -> None:
        super().__init__(JointVelocity(), CONFIG)
        self.states: list[State] = []
        self.seconds: list[float] = []

    def _command(self, runtime: Runtime) -> None:
        q, v = runtime.robot.joint_positions, runtime.robot.joint_velocities
        self.states.append((q, v, wanted_velocity(runtime, q, v).copy()))
        began = time.process_time()
        super()._command(runtime)
        self.seconds.append(time.process_time() - began)

    def alone(self, runtime: Runtime) -> list[float]:
        """Filter the states again, and nothing else; return the processor time of each [s]."""
        guard: SafetyFilter = runtime.bound(self).filter
        seconds = []
        for state in self.states:
            began = time.process_time()
            guard.filter(*state)
            seconds.append(time.process_time() - began)
        return seconds


class Judge:
    """Measures the simulated arm after every tick."""

    def __init__(self, task: TaskEnvironment) -> None:
        self.task, self.limits, self.dt = task, task.runtime.model.limits, task.world.control_dt
        self.distances = DistanceModel(task.runtime.model)
        self.figures = Figures()

    def look(self) -> None:
        """Begin an episode."""
        self.v = self.task.world.robot.joint_velocities

    def judge(self, arm: SafeArm) -> None:
        """Measure one tick."""
        f, robot, limits = self.figures, self.task.world.robot, self.limits
        q, v = robot.joint_positions, robot.joint_velocities
        f.actions += 1
        f.position += bool((q < limits.lower - 1e-6).any() or (q > limits.upper + 1e-6).any())
        f.velocity += bool((np.abs(v) > limits.velocity * 1.001).any())
        f.acceleration += bool((np.abs(v - self.v) / self.dt > limits.acceleration * 1.01).any())
        f.contact += bool(robot.touching())
        self.v = v
        self._judge_distances(q)
        reasons = set(arm.last.reasons) if arm.last is not None else set()
        f.clipped += reasons == {"limits"}
        f.avoided += bool(reasons - {"limits"})
        f.stops += arm.last is not None and arm.last.stopped

    def _judge_distances(self, q: FloatArray) -> None:
        f, model = self.figures, self.distances
        model.update(self.task.world.snapshot())
        model.place(q)
        near = np.flatnonzero(model.counts & (model.bounds < 0.1))  # bounds from below
        distances, world = model.measure(near), model.crosses[near]
        to_world, to_self = distances[world].min(initial=np.inf), distances[~world].min(initial=np.inf)
        f.nearest_world_m, f.nearest_self_m = min(f.nearest_world_m, to_world), min(f.nearest_self_m, to_self)
        f.distance += bool(to_world < CONFIG.margin - SLACK or to_self < CONFIG.self_margin - SLACK)


def measure_scene(name: str, actions: int, hold: int = 1, seed: int = 0) -> Figures:
    """Run random actions, each held for some ticks, in the scene of one task, 200 per episode."""
    arm, observations, rng = TimedArm(), ObservationConfig(), np.random.default_rng(seed)
    observations.set_all(False)
    with Environment(MoveArmThenGripper(arm, Discrete()), obs_config=observations, seed=0) as env:
        task = env.get_task(name)
        judge, fastest = Judge(task), task.runtime.model.limits.velocity
        for tick in range(actions):
            if tick % EPISODE == 0:
                arm.states.clear()
                task.reset(seed=seed + tick)
                judge.look()
            if tick % EPISODE % hold == 0:
                action = np.append(rng.uniform(-fastest, fastest), 1.0)
            task.step(action)
            judge.judge(arm)
        judge.figures.loop_tick_us, judge.figures.tick_us = _percentiles(arm.seconds), _percentiles(arm.alone(task.runtime))
    return judge.figures


def _percentiles(seconds: Sequence[float]) -> dict[str, float]:
    return {name: round(1e6 * float(np.percentile(seconds, p)), 1) for name, p in (("median", 50), ("p95", 95), ("p99", 99))}


def benchmark(actions: int = 1000, tasks: Sequence[str] = TASKS[:2]) -> list[Result]:
    """Measure few actions in few scenes."""
    return [_result(f"safe tick, {name}", measure_scene(name, actions)) for name in tasks]


def _result(name: str, f: Figures) -> Result:
    nearest = f"{1e3 * f.nearest_world_m:.1f} mm from the world, {1e3 * f.nearest_self_m:.1f} mm from itself at least"
    note = f"{f.violations()} violations, {nearest}, distances active in {f.avoided / f.actions:.0%}"
    times = {key: 1e-6 * value for key, value in f.tick_us.items()}
    return Result(name, f.actions, **times, note=note, extra={"violations": float(f.violations())})


def main() -> None:
    """Measure, print one line per scene, write both files."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--actions", type=int, default=200_000, help="actions in all, each new")
    parser.add_argument("--held", type=int, default=20_000, help=f"actions in all, each kept for {HOLD} ticks")
    parser.add_argument("--tasks", nargs="+", default=TASKS)
    parser.add_argument("--out", type=Path, default=Path("docs/results"), help="folder for safety.json and safety.md")
    options = parser.parse_args()
    results: dict[str, dict[str, Figures]] = {"fresh": {}, "held": {}}
    for policy, actions, hold in (("held", options.held, HOLD), ("fresh", options.actions, 1)):
        for name in options.tasks:
            results[policy][name] = measure_scene(name, actions // len(options.tasks), hold)
            print(policy, _result(name, results[policy][name]).line(), flush=True)
            _write(results, options.out)


def _write(results: dict[str, dict[str, Figures]], out: Path) -> None:
    """Write what there is so far."""
    out.mkdir(parents=True, exist_ok=True)
    scenes = {policy: {name: asdict(f) for name, f in scenes.items()} for policy, scenes in results.items()}
    content = {"margin_m": CONFIG.margin, "self_margin_m": CONFIG.self_margin, "slack_m": SLACK, "hold_ticks": HOLD, **scenes}
    (out / "safety.json").write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    (out / "safety.md").write_text(report(content), encoding="utf-8")


if __name__ == "__main__":
    main()
