"""Planning problems, solved by the plain planner and by ours in the same run; a table, and a log for OMPL's Planner Arena.

Times are processor time, so that other work on the machine does not count. The plain planner and `search` find a path of
straight joint-space edges; `complete` is `search` and all that makes a motion of it: shortcuts, rounding, continuous
collision check, timing with torque limits. `search` checks its edges half as often as the plain planner, every 0.1 rad,
because its path is checked more finely, repaired and certified afterwards.
"""

from __future__ import annotations

import argparse
import platform
import time
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import numpy as np
from harness import Result, summary
from plain_planner import PlainPlanner
from problems import PER_KIND, all_problems

from rlbench_pin.errors import PlanningError
from rlbench_pin.planning.plan import PlannerConfig
from rlbench_pin.planning.planner import MotionPlanner
from rlbench_pin.planning.problems import PlanningProblem, read_problem
from rlbench_pin.planning.search import sample_path
from rlbench_pin.robot.collision import CollisionModel
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray

MARGIN = 0.003
STEP = 0.05
"""Resolution of the plain planner's edge checks [rad]."""
BUDGET = 400_000
"""State checks of our search."""
FINE = 1e-4
"""Resolution of the last check of accepted motions [rad]."""


@dataclass(frozen=True)
class Run:
    """Result of one planner on one problem."""

    solved: bool
    seconds: float
    """Processor time [s]."""
    length: float = np.nan
    """Joint-space length [rad]."""
    clearance: float = np.nan
    """Smallest distance of the arm to anything along the path [m]."""
    checks: int = 0
    collisions: int = 0
    """Configurations of the accepted path that touch something, looking every `FINE` rad."""


def run_plain(model: RobotModel, problem: PlanningProblem, seed: int, limit: float) -> tuple[Run, Run]:
    """Return the plain planner without and with simplification."""
    result = PlainPlanner(model, problem, MARGIN).solve(problem.start, problem.goal, seed=seed, step=STEP, limit=limit)  # type: ignore[arg-type]
    solved = result.path is not None
    length, clearance = (
        (_length(result.path), _clearance(model, problem, _filled(result.path, 0.1))) if solved else (np.nan, np.nan)
    )
    search = Run(solved, result.seconds, checks=result.checks)
    return search, Run(solved, result.seconds + result.simplify_seconds, length, clearance, result.checks)


def run_search(model: RobotModel, collision: CollisionModel, problem: PlanningProblem, seed: int) -> Run:
    """Find a path with the same margins as the plain planner, edges checked half as often, and nothing more."""
    collision.update(problem.world)
    first, began = collision.checks, time.process_time()
    collision.begin(problem.start, margin=MARGIN)
    try:
        sample_path(
            problem.start, [problem.goal], lambda q: not collision.in_collision(q), model.limits,
            seed=seed, checks=BUDGET, step=2 * STEP,
        )  # fmt: skip
        solved = True
    except PlanningError:
        solved = False
    return Run(solved, time.process_time() - began, checks=collision.checks - first)


def run_complete(planner: MotionPlanner, problem: PlanningProblem, seed: int, fine: bool) -> Run:
    """Plan the whole motion, and check it finely afterwards."""
    planner.update(problem.world)
    began = time.process_time()
    try:
        plan = planner.plan_to_configuration(
            problem.start, problem.goal, allowed=problem.allowed, rng=np.random.default_rng(seed)
        )
    except PlanningError:
        return Run(False, time.process_time() - began)
    seconds, model = time.process_time() - began, planner.model
    collisions = 0
    if fine:
        checker = CollisionModel(model)
        checker.update(problem.world)
        checker.allow(problem.allowed)
        collisions = sum(checker.in_collision(q) for q in _filled(plan.trajectory.q, FINE))
    return Run(True, seconds, plan.report.length, _clearance(model, problem, plan.path), plan.report.checks, collisions)


def _filled(path: FloatArray, step: float) -> FloatArray:
    """Return the polyline with configurations at most `step` apart."""
    parts = [np.linspace(a, b, int(np.abs(b - a).max() / step) + 2)[:-1] for a, b in zip(path[:-1], path[1:], strict=True)]
    return np.concatenate([*parts, path[-1:]])


def _length(path: FloatArray) -> float:
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def _clearance(model: RobotModel, problem: PlanningProblem, path: FloatArray) -> float:
    """Return the smallest distance to anything along a path."""
    checker = CollisionModel(model)
    checker.update(problem.world)
    return min(float(d.distance) for q in path for d in checker.distances(q)[:1])


# Results ----------------------------------------------------------------------------------------------------------


def row(name: str, runs: Sequence[Run]) -> str:
    """One row of the table; unsolved problems count with the time that they took."""
    times = 1e3 * np.array([r.seconds for r in runs])
    solved = [r for r in runs if r.solved]
    mean = [
        np.nanmean(v) if np.isfinite(v).any() else np.nan for v in ([r.length for r in solved], [r.clearance for r in solved])
    ]
    shown = [f"{mean[0]:.2f}" if np.isfinite(mean[0]) else "", f"{1e3 * mean[1]:.1f}" if np.isfinite(mean[1]) else ""]
    cells = [f"{len(solved)}/{len(runs)}", f"{np.median(times):.1f}", f"{np.percentile(times, 95):.1f}", *shown]
    return f"| {name} | " + " | ".join(cells) + f" | {np.median([r.checks for r in runs]):.0f} |"


HEAD = "| planner | solved | median ms | p95 ms | length rad | clearance mm | checks |\n|---|---|---|---|---|---|---|"


def arena_log(name: str, results: dict[str, list[Run]], limit: float) -> str:
    """Return the results as an OMPL benchmark log; each problem is a run."""
    count = len(next(iter(results.values())))
    lines = [
        "OMPL version 2.0.1", f"Experiment {name}", f"Running on {platform.machine()}",
        f"Starting at {datetime.now():%Y-%m-%d %H:%M:%S}",
        "<<<|", "Panda arm, joint space; one run per problem", "|>>>", "1 is the random seed", f"{limit} seconds per run",
        "1000 MB per run", f"{count} runs per planner", "0 seconds spent to collect the data", "1 enum type",
        "status|Unknown|Invalid start|Invalid goal|Unrecognized goal type|Timeout|Approximate solution|Exact solution|Crash"
        "|Abort|Infeasible",
        f"{len(results)} planners",
    ]  # fmt: skip
    for planner, runs in results.items():
        lines += [f"geometric_{planner}", "0 common properties", "6 properties for each run"]
        lines += [
            "time REAL",
            "solved BOOLEAN",
            "status ENUM",
            "solution length REAL",
            "solution clearance REAL",
            "collision checks INTEGER",
        ]
        lines += [f"{len(runs)} runs"]
        for r in runs:
            lines.append(
                f"{r.seconds}; {int(r.solved)}; {6 if r.solved else 4}; {_or_empty(r.length)}; {_or_empty(r.clearance)}; "
                f"{r.checks}; "
            )
        lines.append(".")
    return "\n".join(lines) + "\n"


def _or_empty(value: float) -> str:
    return "" if np.isnan(value) else str(value)


def solve_all(problems: Sequence[PlanningProblem], limit: float, fine: bool) -> dict[str, list[Run]]:
    """Run every planner on every problem, one problem after the other."""
    model = problems[0].model()
    collision = CollisionModel(model)
    planners = {c: MotionPlanner(model, PlannerConfig(checks=BUDGET, certify=c)) for c in (True, False)}
    results: dict[str, list[Run]] = {n: [] for n in ("plain", "plain_simplified", "search", "complete", "complete_uncertified")}
    for seed, problem in enumerate(problems, start=1):
        plain, simplified = run_plain(model, problem, seed, limit)
        results["plain"].append(plain)
        results["plain_simplified"].append(simplified)
        results["search"].append(run_search(model, collision, problem, seed))
        results["complete"].append(run_complete(planners[True], problem, seed, fine))
        results["complete_uncertified"].append(run_complete(planners[False], problem, seed, False))
    return results


def benchmark(per_kind: int = PER_KIND) -> list[Result]:
    """Solve the generated problems with search alone, and with complete motions."""
    problems = all_problems(per_kind)
    model = problems[0].model()
    collision, planner = CollisionModel(model), MotionPlanner(model, PlannerConfig(checks=BUDGET))
    for seed, problem in enumerate(problems[:3]):  # warm up
        run_complete(planner, problem, seed, fine=False)
    parts = {
        "search": [run_search(model, collision, problem, seed) for seed, problem in enumerate(problems, start=1)],
        "complete motions": [run_complete(planner, problem, seed, fine=False) for seed, problem in enumerate(problems, start=1)],
    }
    return [
        summary(f"planning problems, {what}", [r.seconds for r in runs], f"{sum(r.solved for r in runs)} of {len(runs)} solved")
        for what, runs in parts.items()
    ]


def table(problems: Sequence[PlanningProblem], results: dict[str, list[Run]], limit: float, fine: bool) -> str:
    """Return the page of results."""
    kinds = sorted({p.name.rsplit("_", 1)[0] for p in problems})
    plain, search = ([r.seconds for r in results[n]] for n in ("plain", "search"))
    ratio = [np.percentile(plain, p) / np.percentile(search, p) for p in (50, 95)]
    lines = [
        "# Planning problems",
        "",
        "Made by `python benchmarks/bench_planning.py --fine --out docs/results/planning.md`.",
        (__doc__ or "").split("\n\n")[1].strip(),
        "",
    ]
    lines += [f"All {len(problems)} problems; the plain planner gives up after {limit:g} s.", "", HEAD]
    lines += [row(name, runs) for name, runs in results.items()]
    lines += [
        "",
        f"`plain` takes {ratio[0]:.1f} times as long as `search` in the median and {ratio[1]:.1f} times at the 95th percentile.",
    ]
    checked, unchecked = (np.median([r.seconds for r in results[name]]) for name in ("complete", "complete_uncertified"))
    lines += [f"The continuous collision check takes {1e3 * (checked - unchecked):.1f} ms in the median."]
    if fine:
        hits = sum(r.collisions for r in results["complete"])
        lines += [f"Accepted motions, checked every {FINE:g} rad with exact shapes: {hits} configurations in collision."]
    for kind in kinds:
        chosen = [i for i, p in enumerate(problems) if p.name.startswith(kind)]
        lines += ["", f"## {kind}", "", HEAD, *(row(name, [runs[i] for i in chosen]) for name, runs in results.items())]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--per-kind", type=int, default=PER_KIND, help="generated problems of each kind")
    parser.add_argument("--first-seed", type=int, default=0, help="seed of the first problem of each kind")
    parser.add_argument("--problems", type=Path, help="folder of JSON problems to solve instead")
    parser.add_argument("--limit", type=float, default=5.0, help="processor time after which the plain planner gives up [s]")
    parser.add_argument("--fine", action="store_true", help="check accepted motions every 1e-4 rad")
    parser.add_argument("--out", type=Path, help="file for the table; the log goes beside it")
    arguments = parser.parse_args()
    if arguments.problems is None:
        problems = all_problems(arguments.per_kind, arguments.first_seed)
    else:
        problems = [p for p in map(read_problem, sorted(arguments.problems.glob("*.json"))) if p.goal is not None]
    results = solve_all(problems, arguments.limit, arguments.fine)
    page = table(problems, results, arguments.limit, arguments.fine)
    print(page)
    if arguments.out is not None:
        arguments.out.parent.mkdir(parents=True, exist_ok=True)
        arguments.out.write_text(page, encoding="utf-8")
        arguments.out.with_suffix(".log").write_text(arena_log("rlbench_pin", results, arguments.limit), encoding="utf-8")


if __name__ == "__main__":
    main()
