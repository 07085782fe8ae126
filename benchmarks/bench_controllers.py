"""Every controller on the segments of demonstrations: errors, limits, clearance, cost of a command.

Usage: python benchmarks/bench_controllers.py [--tasks NAME ...] [--episodes N] [--segments N] [--out docs/results]
Writes controllers.json and controllers.md.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path

from controllers import PLAN, ControllerComparison, ControllerSummary, SegmentTrial, report, summarise_segments
from harness import Result, summary

from rlbench_pin.cli.evaluate import TASKS

EXPLANATION = """# Controllers on demonstrations

Written by `python benchmarks/bench_controllers.py`.

Every controller follows the same segments of demonstrations ({episodes} of each of {tasks} tasks), in simulation, each from
the state in which the segment began. Torques are commanded 240 times a second, all else 20 times.

* `tip`, `joint`: errors of the tip's place and of the worst joint at the end of every control tick, median / maximum.
* `end`: largest error of the tip after a segment. `overtime`: time until the arm rests within 1 mm of the planned end, one
  second at most, median / maximum.
* `violations`: ticks beyond the limits of joint position / velocity / acceleration.
* `touched`: segments on which something was touched that was not touched at the start. `clearance`: smallest distance to the
  world as it stood when the segment began. On segments that may touch, touching is often the purpose, and a negative
  clearance is how far the arm got into the place of what it pushed away.
* `filtered`, `stops`: shares of commands that a safety filter changed, and that were braking.
* `us`: median processor time of a command.

Notes on the tables:

* Torque controllers have the mass of the grasped body at the start of a segment. `OperationalSpaceQP` and
  `CartesianImpedance` pull with bounded or springy forces, so where something holds the arm back they lag instead of pushing
  through. Torques are chosen for an arm that nothing touches: on segments that may touch, a hit can move joints faster than
  that.
* Other controllers of the tip leave the elbow free, so their joint errors say where the elbow went, not how well they follow.
* `DifferentialIK, poses` brakes for each pose as if it were the last; timed motions are better followed by twists.
* Filter and prediction keep 3 mm, also where a plan passes nearer, and the filter slows what approaches: it needs longer
  where a segment ends near something. On segments that may touch, both tolerate only what is touched at the start, so they
  refuse to press.

"""


def benchmark(tasks: Sequence[str] = ("pick_and_lift", "open_drawer"), segments: int = 2) -> list[Result]:
    """Follow few segments of few tasks."""
    evaluation = ControllerComparison(tasks=tuple(tasks), segments=segments)
    trials = list(evaluation.trials())
    free = {s.controller: s for s in summarise_segments(trials) if s.kind == "free"}
    return [_result(free[name], [t for t in trials if t.controller == name]) for name in free if name != PLAN]


def _result(figures: ControllerSummary, trials: Sequence[SegmentTrial]) -> Result:
    broken = sum(figures.violations.values())
    error = f"tip {figures.tip_median_mm:.2f} mm off, {figures.tip_max_mm:.1f} at most"
    note = f"{error}, {broken} violations, {figures.touched} touches"
    seconds = [float(s) for t in trials for s in t.seconds]
    return summary(f"command, {figures.controller}", seconds, note, tip_max_mm=figures.tip_max_mm, violations=float(broken))


def main() -> None:
    """Measure, print the tables, write both files."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tasks", nargs="+", default=TASKS)
    parser.add_argument("--episodes", type=int, default=1)
    parser.add_argument("--segments", type=int, help="most segments of each demonstration")
    parser.add_argument("--out", type=Path, default=Path("docs/results"), help="folder for controllers.json and controllers.md")
    options = parser.parse_args()
    evaluation = ControllerComparison(tasks=tuple(options.tasks), episodes=options.episodes, segments=options.segments)
    summaries = summarise_segments(list(evaluation.trials()))
    tables = report(summaries, title="## ")
    print(tables)
    options.out.mkdir(parents=True, exist_ok=True)
    content = json.dumps(evaluation.content(summaries), indent=1) + "\n"
    (options.out / "controllers.json").write_text(content, encoding="utf-8")
    text = EXPLANATION.format(episodes=options.episodes, tasks=len(options.tasks)) + tables + "\n"
    (options.out / "controllers.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
