"""Demonstrate every task with every arm, and write docs/results/arms.json, .md and .png.

Usage: python scripts/arms_matrix.py [TASK ...] [--robots NAME ...] [--episodes 20] [--workers 2] [--out docs/results]
A cell is the fraction of seeds whose first demonstration succeeds; docs/results/demo_success.json has those of the Panda.
Finished trials are stored in out/arms: the same command resumes after an interruption, and unchanged tasks are not played again.
`--report` writes the present results, and plays nothing. Arms without a name on the command line keep their rates in the table.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from tqdm import tqdm

from rlbench_pin.checking.page import interval
from rlbench_pin.checking.plan import Item
from rlbench_pin.checking.records import DemoTrial
from rlbench_pin.checking.run import CheckProgress, TrialJournal, run_trials
from rlbench_pin.rates import Rate
from rlbench_pin.robot import DEFAULT_ROBOT, SUPPORTED_ROBOTS
from rlbench_pin.tasks import library_names

ROOT = Path(__file__).resolve().parents[1]
ENOUGH = 0.8
"""A cell below this share has a cause in the table."""
VARIATIONS = 100
AT_ONCE = 5
CAUSES = {"reset": "placement", "unreachable": "IK", "outside joint limits": "IK", "DemoError": "grasp or contact"}
"""Beginning of the message of a failure -> cause; other failures are of planning."""
_FIXED = {"font.family": "DejaVu Sans", "font.size": 7.0}


def cause_of(trial: DemoTrial) -> str:
    """Return the cause of a trial that failed."""
    message = trial.error or trial.failed[0].cause
    return CAUSES.get(message.partition(":")[0], "planning")


def items_of(robot: str, tasks: Sequence[str], episodes: int) -> list[Item]:
    """Return the work for one arm: one try of each seed, no replay."""
    chunks = [tuple(range(i, min(i + AT_ONCE, episodes))) for i in range(0, episodes, AT_ONCE)]
    return [Item(task, "demos", seeds, VARIATIONS, max_attempts=1, replays=0, robot=robot) for task in tasks for seeds in chunks]


def cell(trials: Sequence[DemoTrial]) -> dict[str, object]:
    """Return one cell of the matrix: the rate of first tries with its interval, and the causes of the failures."""
    failed = [trial for trial in trials if trial.demo is None]
    causes = Counter(cause_of(trial) for trial in failed)
    return {**Rate(len(trials) - len(failed), len(trials)).as_dict(), "causes": dict(causes.most_common())}


def swept(tasks: Sequence[str]) -> dict[str, dict[str, object]]:
    """Return the cells of the Panda, from the sweep of all tasks."""
    table = json.loads((ROOT / "docs" / "results" / "demo_success.json").read_text(encoding="utf-8"))["tasks"]
    return {task: {**table[task]["first_try"], "causes": {}} for task in tasks if task in table}


def draw(path: Path, rates: np.ndarray, tasks: Sequence[str], robots: Sequence[str]) -> None:
    """Draw the matrix (tasks, robots) as a heat map; what was not played is white."""
    with rc_context(_FIXED):
        columns = 4
        rows = -(-len(tasks) // columns)
        figure = Figure(figsize=(3.0 * columns, 0.13 * rows + 1.2), layout="constrained")
        for k, axes in enumerate(figure.subplots(1, columns)):
            part = slice(k * rows, (k + 1) * rows)
            axes.imshow(rates[part], vmin=0.0, vmax=1.0, cmap="RdYlGn", aspect="auto")
            axes.set_yticks(range(len(tasks[part])), tasks[part])
            axes.set_xticks(range(len(robots)), robots, rotation=45)
            for (row, column), rate in np.ndenumerate(rates[part]):
                if rate < 0.995:
                    axes.text(column, row, f"{100 * rate:.0f}", ha="center", va="center", fontsize=5)
        figure.suptitle("First tries that succeed [%]; cells without a number: 100")
        figure.savefig(path, dpi=130, metadata={"Software": None})


def page(matrix: Mapping[str, Mapping[str, dict[str, object]]], tasks: Sequence[str]) -> str:
    """Return the matrix as Markdown: a summary for each arm, then the cells, with causes where less than 80 % succeed."""
    robots = list(matrix)
    lines = [
        "# Arms and tasks",
        "",
        "Written by `python scripts/arms_matrix.py`. First tries that succeed, with the 95 % Wilson interval.",
        "The figures of the Panda are those of the [sweep of all tasks](demo_success.md).",
        "",
    ]
    lines += ["| Arm | Tasks at 80 % or more | First tries |", "|---|---|---|"]
    for robot in robots:
        cells = [matrix[robot][task] for task in tasks if task in matrix[robot]]
        good = sum(float(str(c["rate"])) >= ENOUGH for c in cells)
        tries = Rate(sum(int(str(c["count"])) for c in cells), sum(int(str(c["of"])) for c in cells))
        lines.append(f"| `{robot}` | {good} of {len(cells)} | {tries.count} of {tries.of} ({100 * tries.value:.1f} %) |")
    lines += ["", "![matrix](arms.png)", "", f"| Task | {' | '.join(robots)} |", f"|---|{'---|' * len(robots)}"]
    lines += [f"| `{task}` | {' | '.join(_text(matrix[robot].get(task)) for robot in robots)} |" for task in tasks]
    return "\n".join(lines) + "\n"


def _text(found: dict[str, object] | None) -> str:
    if found is None:
        return ""
    text = interval(found)
    causes = found["causes"]
    assert isinstance(causes, dict)
    below = float(str(found["rate"])) < ENOUGH
    return text + (": " + ", ".join(f"{cause} {count}" for cause, count in causes.items()) if below else "")


def main() -> None:
    """Play what is missing, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tasks", nargs="*", default=library_names(), help="all when none is named")
    arms = list(SUPPORTED_ROBOTS)
    parser.add_argument("--robots", nargs="+", choices=arms, default=arms, help="all when none is named")
    parser.add_argument("--episodes", type=int, default=20, help="seeds of each cell")
    parser.add_argument("--workers", type=int, default=2, help="processes")
    parser.add_argument("--report", action="store_true", help="play nothing")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "results", help="folder for arms.json, .md and .png")
    options = parser.parse_args()
    journal = TrialJournal(ROOT / "out" / "arms" / "trials.jsonl", options.tasks)
    table = options.out / "arms.json"
    known = json.loads(table.read_text(encoding="utf-8"))["arms"] if table.is_file() else {}
    matrix: dict[str, dict[str, dict[str, object]]] = {}
    for robot in arms:
        if robot not in options.robots:
            matrix |= {robot: known[robot]} if robot in known else {}
            continue
        if robot == DEFAULT_ROBOT:
            matrix[robot] = swept(options.tasks)
            continue
        items = items_of(robot, options.tasks, options.episodes)
        if options.report:
            items = [item for item in items if journal.trials_of(item) is not None]
        with tqdm(total=sum(len(item.seeds) for item in items), desc=robot, unit="demo") as bar:

            def show(progress: CheckProgress, bar: tqdm[None] = bar) -> None:
                bar.update(progress.done - bar.n)

            trials = [t for t in run_trials(items, options.workers, journal, show) if isinstance(t, DemoTrial)]
        played = {task: [trial for trial in trials if trial.task == task] for task in options.tasks}
        matrix[robot] = {task: cell(found) for task, found in played.items() if found}
    tasks = [task for task in options.tasks if any(task in cells for cells in matrix.values())]
    rates = np.array(
        [[float(str(cells[task]["rate"])) if task in cells else np.nan for cells in matrix.values()] for task in tasks]
    )
    options.out.mkdir(parents=True, exist_ok=True)
    table.write_text(json.dumps({"episodes": options.episodes, "arms": matrix}, indent=1) + "\n", encoding="utf-8")
    (options.out / "arms.md").write_text(page(matrix, tasks), encoding="utf-8")
    draw(options.out / "arms.png", rates, tasks, list(matrix))


if __name__ == "__main__":
    main()
