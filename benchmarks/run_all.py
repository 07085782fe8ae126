"""Run every benchmark, print one table, write JSON. A stopped run goes on: what was measured of the same sources is kept.

python benchmarks/run_all.py --out benchmarks/results                 # `make bench`
python benchmarks/run_all.py --only step reset --against OLD.json     # some of them, beside an earlier run
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path

import bench_cameras
import bench_control_ik
import bench_control_loops
import bench_controllers
import bench_dataset
import bench_demo
import bench_planning
import bench_planning_segments
import bench_reset
import bench_safety
import bench_step
from harness import Result, fingerprint, report

BENCHMARKS: dict[str, Callable[[bool], Sequence[Result]]] = {
    "step": lambda quick: bench_step.benchmark(),
    "reset": lambda quick: bench_reset.benchmark(repeats=3 if quick else 20),
    "planning": lambda quick: bench_planning_segments.benchmark(seeds=1 if quick else 5),
    "problems": lambda quick: bench_planning.benchmark(2 if quick else 25),
    "demo": lambda quick: bench_demo.benchmark(seeds=1 if quick else 5),
    "cameras": lambda quick: bench_cameras.benchmark(),
    "control_ik": lambda quick: bench_control_ik.benchmark(*((4, 20) if quick else (10, 200))),
    "control_loops": lambda quick: bench_control_loops.benchmark(100 if quick else 1000),
    "dataset": lambda quick: bench_dataset.benchmark(*((2, 20) if quick else (20, 1000))),
    "safety": lambda quick: bench_safety.benchmark(100 if quick else 1000),
    "controllers": lambda quick: bench_controllers.benchmark(("reach_target",) if quick else ("pick_and_lift", "open_drawer")),
}
"""Name -> how to run it, quickly or as well as a run of all allows."""


def kept(part: Path, key: dict[str, object]) -> list[Result] | None:
    """Return the results of a finished part, when it was measured with the same sources and settings."""
    if not part.is_file():
        return None
    content = json.loads(part.read_text(encoding="utf-8"))
    return [Result(**r) for r in content["results"]] if content["key"] == key else None


def run(name: str, part: Path, key: dict[str, object]) -> list[Result]:
    """Measure one part and keep it."""
    results = list(BENCHMARKS[name](bool(key["quick"])))
    part.parent.mkdir(parents=True, exist_ok=True)
    unfinished = part.with_suffix(".tmp")
    unfinished.write_text(json.dumps({"key": key, "results": [asdict(r) for r in results]}) + "\n", encoding="utf-8")
    unfinished.replace(part)
    return results


def main() -> None:
    """Measure everything."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=tuple(BENCHMARKS), default=tuple(BENCHMARKS), help="some of them")
    parser.add_argument("--quick", action="store_true", help="few repetitions: whether it runs, not how fast")
    parser.add_argument("--fresh", action="store_true", help="measure again what was measured of the same sources")
    parser.add_argument("--out", type=Path, default=Path("benchmarks/results"), help="folder for latest.json and finished parts")
    parser.add_argument("--against", type=Path, help="JSON file of an earlier run to compare with")
    arguments = parser.parse_args()
    key: dict[str, object] = {"sources": fingerprint(), "quick": arguments.quick}
    results: list[Result] = []
    for k, name in enumerate(arguments.only, start=1):
        part, began = arguments.out / "parts" / f"{name}.json", time.monotonic()
        found = None if arguments.fresh else kept(part, key)
        results += run(name, part, key) if found is None else found
        done = "kept" if found is not None else f"{time.monotonic() - began:.0f} s"
        print(f"[{k}/{len(arguments.only)}] {name}: {done}", file=sys.stderr, flush=True)
    report(results, arguments.out / "latest.json", arguments.against)


if __name__ == "__main__":
    main()
