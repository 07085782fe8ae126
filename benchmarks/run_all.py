"""Run every benchmark, print one table, write JSON."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path

import bench_cameras
import bench_control_ik
import bench_control_loops
import bench_controllers
import bench_demo
import bench_planning_leg
import bench_reset
import bench_safety
import bench_step
from harness import Result, report

BENCHMARKS: dict[str, Callable[[bool], Sequence[Result]]] = {
    "step": lambda quick: bench_step.benchmark(),
    "reset": lambda quick: bench_reset.benchmark(),
    "planning": lambda quick: bench_planning_leg.benchmark(),
    "demo": lambda quick: bench_demo.benchmark(),
    "cameras": lambda quick: bench_cameras.benchmark(),
    "control_ik": lambda quick: bench_control_ik.benchmark(*((4, 20) if quick else (10, 200))),
    "control_loops": lambda quick: bench_control_loops.benchmark(100 if quick else 1000),
    "safety": lambda quick: bench_safety.benchmark(100 if quick else 1000),
    "controllers": lambda quick: bench_controllers.benchmark(("reach_target",) if quick else ("pick_and_lift", "open_drawer")),
}
"""Name -> how to run it, quickly or as well as a run of all allows."""


def main() -> None:
    """Measure everything."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="+", choices=tuple(BENCHMARKS), default=tuple(BENCHMARKS), help="some of them")
    parser.add_argument("--quick", action="store_true", help="few repetitions: whether it runs, not how fast")
    parser.add_argument("--out", type=Path, default=Path("benchmarks/results"), help="folder for latest.json")
    parser.add_argument("--against", type=Path, help="JSON file of an earlier run to compare with")
    arguments = parser.parse_args()
    results = [r for name in arguments.only for r in BENCHMARKS[name](arguments.quick)]
    report(results, arguments.out / "latest.json", arguments.against)


if __name__ == "__main__":
    main()
