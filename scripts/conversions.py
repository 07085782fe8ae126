"""Replay demonstrations of each arm with every other arm, and write docs/results/conversions.json and .md.

Usage: python scripts/conversions.py [TASK ...] [--robots NAME ...] [--episodes 5] [--workers 2] [--out docs/results]
A cell is the fraction of demonstrations of the first arm that succeed when the tip of the second arm follows the same poses, in
the same scene (`convert_demo`). Finished demonstrations are stored in out/conversions/trials.jsonl: the same command resumes
after an interruption; demonstrations that depend on changed files are repeated. `--report` writes the present results, and
plays nothing.
"""

from __future__ import annotations

import argparse
import json
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from hashlib import sha256
from itertools import permutations
from pathlib import Path

import numpy as np
from tqdm import tqdm

from rlbench_pin.checking.run import task_marks
from rlbench_pin.environment import Environment, TaskEnvironment
from rlbench_pin.environment.demos import EXTRA_TICKS
from rlbench_pin.environment.presets import joint_position_mode, low_dim_config, make_environment
from rlbench_pin.environment.replay import reaches_goal
from rlbench_pin.errors import DemoError, InvalidActionError, ResetError, RlbenchPinError
from rlbench_pin.observation import Demo
from rlbench_pin.processes import GivenUp, Journal, ProcessEngine, WorkerDeath, run_jobs
from rlbench_pin.rates import Rate
from rlbench_pin.recording import convert, convert_demo
from rlbench_pin.robot import SUPPORTED_ROBOTS

ROOT = Path(__file__).resolve().parents[1]
TASKS = (
    "reach_target", "push_button", "pick_and_lift", "pick_up_cup", "put_rubbish_in_bin", "stack_blocks",
    "slide_block_to_target", "take_lid_off_saucepan", "close_box", "turn_tap",
)  # fmt: skip
SAME = 1e-3
"""Largest difference of the states of a task in the same scene [m] or [rad]."""
CAUSES: Mapping[str, str] = {
    "no demonstration": "the first arm does not succeed at its first try",
    "placement": "the reset of the second arm rejects the placement",
    "reach": "the tip of the second arm cannot follow",
    "refused": "an action is refused",
    "contact": "the tip follows, but the goal is not reached",
    "lost": "the worker process died",
}


@dataclass(frozen=True)
class Item:
    """A demonstration, and the arms that replay it."""

    task: str
    source: str
    """Arm that makes the demonstration."""
    seed: int
    targets: tuple[str, ...]
    """Arms that replay it."""
    digest: str
    """SHA-256 of the files on which the trial depends."""


@dataclass(frozen=True)
class Trial:
    """Outcome of an item."""

    task: str
    source: str
    seed: int
    digest: str
    causes: Mapping[str, str]
    """Arm -> why its replay failed; empty for a success."""
    seconds: float = 0.0
    """Process time of the demonstration and all replays [s]."""


class Converter:
    """Makes demonstrations and replays them. It keeps an environment for each arm, and the task that is loaded in it."""

    def __init__(self) -> None:
        self._environments: dict[str, Environment] = {}
        self._tasks: dict[str, TaskEnvironment] = {}

    def make(self, item: Item) -> Trial:
        """Make the demonstration and replay it with every other arm."""
        began = time.process_time()
        demo = self._demo(item)
        causes = {target: "no demonstration" if demo is None else self._replay(item, demo, target) for target in item.targets}
        return Trial(item.task, item.source, item.seed, item.digest, causes, round(time.process_time() - began, 2))

    def close(self) -> None:
        """Free the environments."""
        for environment in self._environments.values():
            environment.shutdown()
        self._environments, self._tasks = {}, {}

    def _demo(self, item: Item) -> Demo | None:
        """Return the demonstration of the first try, None where it fails."""
        try:
            task = self._task(item.source, item.task)
            return task.try_demo(seed=item.seed, variation=item.seed % task.variation_count()).demo
        except RlbenchPinError:
            return None

    def _replay(self, item: Item, demo: Demo, target: str) -> str:
        """Replay a demonstration with another arm, and return why that failed; empty for a success."""
        source, task = self._task(item.source, item.task), self._task(target, item.task)
        try:
            _, seen = task.reset(seed=item.seed, variation=demo.variation_number)
        except ResetError:
            return "placement"
        before, now = demo[0].task_low_dim_state, seen.task_low_dim_state
        assert before is not None and now is not None
        if before.shape != now.shape or np.abs(before - now).max(initial=0.0) > SAME:
            return "placement"
        try:
            actions = convert_demo(demo, joint_position_mode(), source.runtime.model, robot=task.runtime.model)
            return "" if reaches_goal(task, [*actions, *[actions[-1]] * EXTRA_TICKS]) else "contact"
        except DemoError:
            return "reach"
        except InvalidActionError:
            return "refused"

    def _task(self, robot: str, name: str) -> TaskEnvironment:
        if robot not in self._tasks or self._tasks[robot].get_name() != name:
            if robot not in self._environments:
                self._environments[robot] = make_environment(low_dim_config(), robot=robot)
            self._tasks[robot] = self._environments[robot].get_task(name)
        return self._tasks[robot]


def lost(given_up: GivenUp[Item]) -> Trial:
    """Return the trial of an item with which too many workers died."""
    item = given_up.item
    return Trial(item.task, item.source, item.seed, item.digest, dict.fromkeys(item.targets, "lost"))


def found_trials(journal: Journal) -> dict[tuple[str, str, int, str], Trial]:
    """Return the trials of a journal by task, arm, seed and digest."""
    found: dict[tuple[str, str, int, str], Trial] = {}
    for line in journal.lines:
        if line is not None:
            add(found, Trial(**line))
    return found


def add(found: dict[tuple[str, str, int, str], Trial], trial: Trial) -> None:
    """Add a trial; where the same demonstration was played for other arms before, both are joined."""
    key = (trial.task, trial.source, trial.seed, trial.digest)
    before = found.get(key, Trial(*key, {}))
    found[key] = Trial(*key, {**before.causes, **trial.causes}, before.seconds + trial.seconds)


def cell(causes: Sequence[str]) -> dict[str, object]:
    """Return the rate of successes with its interval, and the causes of the failures."""
    failed = Counter(cause for cause in causes if cause)
    return {**Rate(len(causes) - failed.total(), len(causes)).as_dict(), "causes": dict(failed.most_common())}


def table(trials: Sequence[Trial], tasks: Sequence[str], pairs: Sequence[tuple[str, str]]) -> dict[str, dict[str, object]]:
    """Return `first -> second` -> its cell over all tasks, with those of each task under `tasks`."""
    rows: dict[str, dict[str, object]] = {}
    for source, target in pairs:
        of_task = {
            task: [t.causes[target] for t in trials if (t.task, t.source) == (task, source) and target in t.causes]
            for task in tasks
        }
        played = {task: cell(causes) for task, causes in of_task.items() if causes}
        if played:
            rows[f"{source} -> {target}"] = {**cell([c for causes in of_task.values() for c in causes]), "tasks": played}
    return rows


def page(rows: Mapping[str, Mapping[str, object]], tasks: Sequence[str], robots: Sequence[str], episodes: int) -> str:
    """Return the table as Markdown: a matrix of pairs, the causes, and the cells of each task."""
    lines = [
        "# Demonstrations of one arm, replayed by another",
        "",
        f"Written by `python scripts/conversions.py`: {len(tasks)} tasks, {episodes} seeds each. The tip of the second arm",
        "follows the poses of the demonstration from the same scene, open loop (`convert_demo`). Shares of demonstrations that",
        "succeed [%], over all tasks, with the 95 % Wilson interval.",
        "",
        f"| First arm | {' | '.join(robots)} |",
        f"|---|{'---|' * len(robots)}",
    ]
    lines += [f"| `{a}` | " + " | ".join(_rate(rows.get(f"{a} -> {b}")) for b in robots) + " |" for a in robots]
    lines += ["", "Causes of failures:", "", "| Cause | Meaning | Count |", "|---|---|---|"]
    counted: Counter[str] = Counter()
    for row in rows.values():
        counted.update(row["causes"])  # type: ignore[call-overload]
    lines += [f"| {cause} | {about} | {counted[cause]} |" for cause, about in CAUSES.items()]
    lines += ["", "Successes of each pair and task:", "", f"| Pair | {' | '.join(f'`{task}`' for task in tasks)} |"]
    lines += [f"|---|{'---|' * len(tasks)}"]
    for pair, row in rows.items():
        cells: Mapping[str, Mapping[str, object]] = row["tasks"]  # type: ignore[assignment]
        lines.append(f"| {pair} | " + " | ".join(_count(cells.get(task)) for task in tasks) + " |")
    return "\n".join(lines) + "\n"


def _rate(found: Mapping[str, object] | None) -> str:
    if found is None:
        return ""
    low, high = found["wilson_95"]  # type: ignore[misc]
    return f"{100 * float(str(found['rate'])):.0f} ({100 * low:.0f} to {100 * high:.0f})"  # type: ignore[has-type]


def _count(found: Mapping[str, object] | None) -> str:
    if found is None:
        return ""
    causes: Mapping[str, int] = found["causes"]  # type: ignore[assignment]
    why = ", ".join(f"{cause} {count}" for cause, count in causes.items())
    return f"{found['count']} of {found['of']}" + (f": {why}" if why else "")


def main() -> None:
    """Play what is missing, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tasks", nargs="*", default=TASKS, help="names of tasks (default: ten tasks)")
    parser.add_argument("--robots", nargs="+", default=list(SUPPORTED_ROBOTS), help="all when none is named")
    parser.add_argument("--episodes", type=int, default=5, help="demonstrations of each arm and task")
    parser.add_argument("--workers", type=int, default=2, help="processes")
    parser.add_argument("--report", action="store_true", help="play nothing")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "results", help="folder for conversions.json and .md")
    options = parser.parse_args()
    tasks, robots = list(options.tasks), list(options.robots)
    journal = Journal(ROOT / "out" / "conversions" / "trials.jsonl")
    found = found_trials(journal)
    rules = Path(convert.__file__).read_bytes()
    digests = {task: sha256(mark.encode() + rules).hexdigest() for task, mark in task_marks(tasks).items()}
    items = [
        Item(task, source, seed, tuple(target for target in robots if target != source), digests[task])
        for task in tasks
        for source in robots
        for seed in range(options.episodes)
    ]
    done = {item: found.get((item.task, item.source, item.seed, item.digest)) for item in items}
    todo = [item for item, trial in done.items() if trial is None or not set(item.targets) <= set(trial.causes)]

    def store(trial: Trial) -> None:
        journal.append(asdict(trial))
        add(found, trial)

    with tqdm(total=len(items), initial=len(items) - len(todo), unit="demo", disable=options.report) as bar:
        if not options.report:
            for event in run_jobs(todo, Converter, store=store, lost=lost, engine=ProcessEngine(options.workers)):
                bar.update(not isinstance(event, WorkerDeath))
    keys = [(item.task, item.source, item.seed, item.digest) for item in items]
    trials = [found[key] for key in keys if key in found]
    rows = table(trials, tasks, list(permutations(robots, 2)))
    options.out.mkdir(parents=True, exist_ok=True)
    content = {"episodes": options.episodes, "seconds": round(sum(t.seconds for t in trials), 1), "pairs": rows}
    (options.out / "conversions.json").write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    (options.out / "conversions.md").write_text(page(rows, tasks, robots, options.episodes), encoding="utf-8")


if __name__ == "__main__":
    main()
