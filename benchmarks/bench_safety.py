"""Random joint velocities and gripper commands through the safety filter in task scenes: what is violated, and what it costs.

Usage: python benchmarks/bench_safety.py [--actions 1000000] [--workers 2] [--tasks NAME ...] [--shards DIR] [--out docs/results]
Actions are kept for 1 tick, and some for 6 or 12. Every tick is measured: joint positions, velocities and
accelerations against their limits, contacts of the arm in the simulator, and the smallest distances to the world and within the
arm, each against its own margin. Finished pieces are kept in the folder of shards; the same command goes on where it was stopped.
At the end it writes safety.json and safety.md; `--report` writes them from the pieces that there are.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
from harness import Result
from safety_report import report
from safety_scene import CONFIG, SLACK, Figures, measure_scene, merged
from safety_shards import SHARES, Shard, plan, read, run

from rlbench_pin.tasks import task_names

QUICK = ("reach_target", "push_button")


def benchmark(actions: int = 1000, tasks: Sequence[str] = QUICK) -> list[Result]:
    """Measure few actions in few scenes."""
    return [_result(f"safe tick, {name}", measure_scene(name, actions, 1, np.random.default_rng(0))) for name in tasks]


def _result(name: str, f: Figures) -> Result:
    nearest = f"{1e3 * f.nearest_world_m:.1f} mm from the world, {1e3 * f.nearest_self_m:.1f} mm from itself at least"
    note = f"{f.violations()} violations, {nearest}, distances active in {f.avoided / f.ticks:.0%}"
    times = {key: 1e-6 * value for key, value in f.tick_us.items()}
    return Result(name, f.ticks, **times, note=note, extra={"violations": float(f.violations())})


def main() -> None:
    """Play what is missing, say what was violated, write both files."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--actions", type=int, default=1_000_000, help="actions in all, at least")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    parser.add_argument("--tasks", nargs="+", default=task_names(), help="all when none is given")
    parser.add_argument("--shards", type=Path, default=Path("out/safety"), help="folder where finished pieces are kept")
    parser.add_argument("--report", action="store_true", help="play nothing, write the page from the pieces that there are")
    parser.add_argument("--out", type=Path, default=Path("docs/results"), help="folder for safety.json and safety.md")
    options = parser.parse_args()
    shards = plan(options.actions, options.tasks)
    if not options.report:
        for _, figures in run(shards, options.shards, options.workers):
            print("".join(f"{event}\n" for event in figures.events), end="", flush=True)
    _write(shards, options.shards, options.out)


def _write(shards: Sequence[Shard], folder: Path, out: Path) -> None:
    """Write what there is."""
    found = [(shard, figures) for shard in shards if (figures := read(shard, folder)) is not None]
    scenes: dict[int, dict[str, Figures]] = {hold: {} for hold in SHARES}
    for hold, name in dict.fromkeys((shard.hold, shard.task) for shard, _ in found):
        scenes[hold][name] = merged([figures for shard, figures in found if (shard.hold, shard.task) == (hold, name)])
    content = {
        "margin_m": CONFIG.margin,
        "self_margin_m": CONFIG.self_margin,
        "slack_m": SLACK,
        "shards": [len(found), len(shards)],
        "held": {str(hold): {name: asdict(scene) for name, scene in sorted(scenes[hold].items())} for hold in SHARES},
    }
    out.mkdir(parents=True, exist_ok=True)
    (out / "safety.json").write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    (out / "safety.md").write_text(report(content), encoding="utf-8")


if __name__ == "__main__":
    main()
