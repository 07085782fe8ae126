"""Run every benchmark, print one table, write JSON."""

from __future__ import annotations

import argparse
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
from harness import report


def main() -> None:
    """Measure everything."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("benchmarks/results"), help="folder for latest.json")
    parser.add_argument("--against", type=Path, help="JSON file of an earlier run to compare with")
    arguments = parser.parse_args()
    modules = (bench_step, bench_reset, bench_planning_leg, bench_demo, bench_cameras)
    results = [r for module in modules for r in module.benchmark()]
    results += [*bench_control_ik.benchmark(goals=10, poses=200), *bench_control_loops.benchmark(actions=1000)]
    results += [*bench_safety.benchmark(), *bench_controllers.benchmark()]
    report(results, arguments.out / "latest.json", arguments.against)


if __name__ == "__main__":
    main()
