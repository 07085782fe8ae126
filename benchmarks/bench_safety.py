"""Random joint velocities of full range through the safety filter, in simulated task scenes: what is violated, and what it costs.

Usage: python benchmarks/bench_safety.py [--actions 200000] [--tasks NAME ...] [--out FILE]
Every tick is measured: joint positions, velocities and accelerations against their limits, contacts of the arm, and the smallest
distance to the world, which must stay above the margin minus 1 mm.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from harness import Result

from rlbench_pin.control.safety_filter import SafetyConfig
from rlbench_pin.environment import (
    Discrete,
    Environment,
    JointVelocity,
    MoveArmThenGripper,
    ObservationConfig,
    SafeArm,
    TaskEnvironment,
)
from rlbench_pin.environment.safe_arm import LIMIT_MARGIN
from rlbench_pin.robot.distances import DistanceModel

TASKS = (
    "reach_target", "push_button", "pick_and_lift", "take_lid_off_saucepan", "open_drawer",
    "close_microwave", "slide_block_to_target", "stack_blocks", "put_rubbish_in_bin", "meat_off_grill",
)  # fmt: skip
CONFIG = SafetyConfig(limit_margin=LIMIT_MARGIN)
EPISODE = 200
PERCENTILES = {"median": 50, "p95": 95, "p99": 99}
SLACK = 0.001
"""How much below the margin the distance may be [m]."""


def measure(task: TaskEnvironment, arm: SafeArm, config: SafetyConfig, actions: int, seed: int) -> dict[str, Any]:
    """Run `actions` random actions, 200 per episode, and count violations."""
    rng, limits, dt = np.random.default_rng(seed), task.scene.model.limits, task.world.control_dt
    distances = DistanceModel(task.scene.model)
    count = dict.fromkeys(("position", "velocity", "acceleration", "contact", "distance"), 0)
    nearest, ticks, interventions, stops, seconds = np.inf, 0, 0, 0, []
    while ticks < actions:
        task.reset(seed=seed + ticks)
        v = task.world.robot.joint_velocities
        for _ in range(min(EPISODE, actions - ticks)):
            began = time.perf_counter()
            task.step(np.append(rng.uniform(-limits.velocity, limits.velocity), 1.0))
            seconds.append(time.perf_counter() - began)
            q, now = task.world.robot.joint_positions, task.world.robot.joint_velocities
            count["position"] += bool((q < limits.lower - 1e-6).any() or (q > limits.upper + 1e-6).any())
            count["velocity"] += bool((np.abs(now) > limits.velocity * 1.001).any())
            count["acceleration"] += bool((np.abs(now - v) / dt > limits.acceleration * 1.01).any())
            count["contact"] += bool(task.world.robot.touching())
            distances.update(task.world.snapshot())
            pairs = distances.nearest(q, 1)
            nearest = min(nearest, pairs[0].distance if pairs else np.inf)
            count["distance"] += bool(pairs and pairs[0].distance < min(config.margin, config.self_margin) - SLACK)
            v = now
            ticks += 1
            interventions += arm.last is not None and arm.last.intervened
            stops += arm.last is not None and arm.last.stopped
    return {
        "actions": ticks,
        "violations": count,
        "nearest_m": round(float(nearest), 5),
        "interventions": round(interventions / ticks, 4),
        "stops": round(stops / ticks, 4),
        **{f"step_{name}_us": round(1e6 * float(np.percentile(seconds, p)), 1) for name, p in PERCENTILES.items()},
    }


def benchmark(actions: int = 1000, tasks: Sequence[str] = TASKS[:2]) -> list[Result]:
    """Measure few actions in few scenes."""
    results = []
    for name in tasks:
        figures = measure_scene(name, actions)
        violations = sum(figures["violations"].values())
        note = (
            f"{violations} violations, {1e3 * figures['nearest_m']:.1f} mm at least, {figures['interventions']:.0%} interventions"
        )
        times = {key: 1e-6 * figures[f"step_{key}_us"] for key in PERCENTILES}
        results.append(Result(f"safe step, {name}", actions, **times, note=note, extra={"violations": float(violations)}))
    return results


def measure_scene(name: str, actions: int) -> dict[str, Any]:
    """Run random actions in the scene of one task."""
    arm = SafeArm(JointVelocity(), CONFIG)
    observations = ObservationConfig()
    observations.set_all(False)
    with Environment(MoveArmThenGripper(arm, Discrete()), obs_config=observations, seed=0) as env:
        return measure(env.get_task(name), arm, CONFIG, actions, 0)


def main() -> None:
    """Measure, print one line per scene, write JSON when asked."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--actions", type=int, default=200_000)
    parser.add_argument("--tasks", nargs="+", default=TASKS)
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    results = {}
    for name in options.tasks:
        results[name] = measure_scene(name, options.actions // len(options.tasks))
        print(name, json.dumps(results[name]))
    if options.out is not None:
        options.out.write_text(
            json.dumps({"margin_m": CONFIG.margin, "self_margin_m": CONFIG.self_margin, "scenes": results}, indent=1) + "\n"
        )


if __name__ == "__main__":
    main()
