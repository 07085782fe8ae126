"""Segments of demonstrations checked finely: every 1e-4 rad for contact, every ms for torques with the payload."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from harness import velocity_environment

from rlbench_pin.environment.runtime import Listener
from rlbench_pin.errors import PlanningError
from rlbench_pin.planning.path import through
from rlbench_pin.planning.plan import Plan, PlanRequest
from rlbench_pin.planning.planner import MotionPlanner
from rlbench_pin.planning.timing import ArcLimits, TorqueLimits, retime
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks import task_names

FINE = 1e-4
"""Joint distance between two checks [rad]."""


@dataclass(eq=False)
class Inspector(Listener):
    """Inspects every plan to a pose that a planner finds."""

    planner: MotionPlanner
    segments: int = 0
    configurations: int = 0
    collisions: int = 0
    """Configurations in a contact that the rules of the segment do not allow."""
    worst_torque: float = 0.0
    """Largest |tau| / limit."""
    stretch: list[float] = field(default_factory=list)
    """Duration with torque limits over duration without."""
    seconds: list[float] = field(default_factory=list)
    """Process time of each segment [s], all stages."""

    def on_plan(self, request: PlanRequest, outcome: Plan | PlanningError, seconds: float) -> None:
        """Inspect a plan."""
        if not isinstance(outcome, Plan) or request.kind != "pose":
            return
        self.seconds.append(seconds)
        self.segments += 1
        if not request.ignore_collisions:
            self._count_collisions(outcome.trajectory.q)
        if self.planner.torque is not None:
            self._compare_torques(outcome, self.planner.torque)

    def _count_collisions(self, q: FloatArray) -> None:
        """Check the way along configurations (m, n), [rad], every `FINE`."""
        for a, b in zip(q[:-1], q[1:], strict=True):
            count = int(np.abs(b - a).max() / FINE) + 1
            self.configurations += count
            self.collisions += sum(not self.planner.collision.keeps_away(a + k / count * (b - a), 0.0) for k in range(count))

    def _compare_torques(self, plan: Plan, torque: TorqueLimits) -> None:
        """Note the largest torque, and what keeping the limits costs."""
        self.worst_torque = max(self.worst_torque, torque.worst(plan.trajectory))
        limits, config = self.planner.limits, self.planner.config
        arc = ArcLimits(config.max_velocity, config.max_acceleration)
        free = retime(through(plan.path), limits, arc=arc)
        kept = retime(through(plan.path), limits, arc=arc, torque=torque)
        self.stretch.append(kept.duration / max(free.duration, 1e-9))


def inspect(tasks: Sequence[str], segments: int, seeds: int) -> dict[str, float]:
    """Demonstrate tasks until enough segments were seen."""
    inspectors: list[Inspector] = []
    share = -(-segments // len(tasks))
    for name in tasks:
        with velocity_environment() as environment:
            task = environment.get_task(name)
            inspectors.append(inspector := Inspector(task.runtime.planner))
            with task.runtime.listening(inspector):
                for seed in range(seeds):
                    if inspector.segments < share:
                        task.try_demo(seed=seed, variation=seed % task.variation_count(), record=False)
    stretch = np.concatenate([i.stretch for i in inspectors])
    times = 1e3 * np.concatenate([i.seconds for i in inspectors])
    return {
        "segments": sum(i.segments for i in inspectors),
        "configurations": sum(i.configurations for i in inspectors),
        "collisions": sum(i.collisions for i in inspectors),
        "worst |tau|/limit": max(i.worst_torque for i in inspectors),
        "duration ratio, mean": float(stretch.mean()),
        "duration ratio, max": float(stretch.max()),
        "segment median ms": float(np.median(times)),
        "segment p95 ms": float(np.percentile(times, 95)),
    }


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tasks", nargs="*", help="task names; all when none is given")
    parser.add_argument("--segments", type=int, default=500)
    parser.add_argument("--seeds", type=int, default=100, help="most demonstrations of a task")
    parser.add_argument("--out", type=Path, help="JSON file for the result")
    arguments = parser.parse_args()
    result = inspect(arguments.tasks or task_names(), arguments.segments, arguments.seeds)
    print(json.dumps(result, indent=1))
    if arguments.out is not None:
        arguments.out.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
