"""`rlbench-pin check TASK...`: does a task keep its contract, and how often does its demonstration succeed?"""

from __future__ import annotations

import json
import multiprocessing
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

import tyro
from tqdm import tqdm

from rlbench_pin.cli.explain import explain_failure
from rlbench_pin.cli.report import TaskReport, summarise
from rlbench_pin.cli.setup import find_task
from rlbench_pin.cli.statistics import Rate
from rlbench_pin.cli.trials import Item, Part, Trial, work
from rlbench_pin.environment.task_environment import library_versions
from rlbench_pin.tasks import task_class, task_names

CONTRACT_SEEDS = 20
_SEEDS_PER_ITEM = 10


@dataclass(frozen=True)
class Check:
    """Judge tasks: resets repeat, resting and flailing solve nothing, demonstrations succeed and can be replayed."""

    tasks: tyro.conf.Positional[tuple[str, ...]] = ()
    """Task names, as `rlbench-pin list` prints them; all when none is given."""
    task_file: tuple[Path, ...] = ()
    """Task files outside the package, each with its scene file beside it."""
    episodes: int = 100
    """Demonstrations of each task, spread over its variations."""
    variations: int = 20
    """Most variations of a task to draw."""
    seed: int = 0
    """Seed of the first episode; episode i uses seed + i."""
    contract: bool = True
    """Also judge resets, resting and flailing, over 20 seeds each."""
    max_attempts: int = 10
    """Tries for each demonstration."""
    workers: int = 1
    """Processes; the result does not depend on their number."""
    explain: bool = False
    """Play the first try of each cause of failure again: print its evidence and draw the scene into `out/explain`."""
    json: Path | None = None
    """File to write the whole report to."""

    def run(self) -> int:
        """Judge, print a table and the causes of failures; 1 when a task fails."""
        files = {find_task(str(path)).get_name(): str(path) for path in self.task_file}
        asked = self.tasks or (() if files else task_names())
        wanted = {task_class(name).get_name(): name for name in asked} | files
        names = list(wanted)
        trials = self._trials(list(wanted.values()))
        reports = [
            summarise(name, [t for t in trials if t.task == name], find_task(wanted[name]).solved_by_chance) for name in names
        ]
        print(table(reports))
        for report in reports:
            print_failures(report)
            if self.explain:
                explain_failures(report)
        if self.json is not None:
            self._write(self.json, reports)
        return 1 if any(report.faults() for report in reports) else 0

    def _items(self, names: Sequence[str]) -> Iterator[Item]:
        parts: list[tuple[Part, int]] = [("demos", self.episodes)]
        if self.contract:
            parts += [("repeat", CONTRACT_SEEDS), ("idle", CONTRACT_SEEDS), ("random", CONTRACT_SEEDS)]
        for name in names:
            for part, amount in parts:
                seeds = range(self.seed, self.seed + amount)
                for i in range(0, amount, _SEEDS_PER_ITEM):
                    yield Item(name, part, tuple(seeds[i : i + _SEEDS_PER_ITEM]), self.variations, self.max_attempts, self.seed)

    def _trials(self, names: Sequence[str]) -> list[Trial]:
        items = list(self._items(names))
        trials: list[Trial] = []
        with tqdm(total=sum(len(item.seeds) for item in items), unit="episode", desc="check") as bar:
            for done in self._results(items):
                trials += done
                bar.update(len(done))
        return sorted(trials, key=lambda t: (t.task, t.part, t.seed))

    def _results(self, items: Sequence[Item]) -> Iterator[list[Trial]]:
        if self.workers <= 1:
            yield from map(work, items)
            return
        with ProcessPoolExecutor(self.workers, multiprocessing.get_context("spawn")) as pool:
            for future in as_completed([pool.submit(work, item) for item in items]):
                yield future.result()

    def _write(self, path: Path, reports: Sequence[TaskReport]) -> None:
        content = {
            "format": 1,
            "episodes": self.episodes,
            "max_variations": self.variations,
            "seed": self.seed,
            "max_attempts": self.max_attempts,
            "versions": library_versions(),
            "tasks": {report.task: report.as_dict() for report in reports},
        }
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


HEADER = ("task", "var", "first try", "95 %", "in tries", "replay", "rest", "flail", "resets", "demo", "plan", "speed", "verdict")


def table(reports: Sequence[TaskReport]) -> str:
    """Return one line per task under a line of headings."""
    rows = [HEADER, *map(_row, reports)]
    widths = [max(map(len, column)) for column in zip(*rows)]
    return "\n".join("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in rows)


def _row(r: TaskReport) -> tuple[str, ...]:
    low, high = r.first_try.interval
    rates = (r.within_tries, r.replay, r.idle, r.random, r.repeat)
    return (
        r.task,
        str(len(r.variations)),
        _share(r.first_try),
        f"{low:.0%}..{high:.0%}",
        *map(_share, rates),
        f"{r.simulated:.1f} s",
        f"{1000 * r.planning:.0f} ms",
        f"{r.speed:.0f} x",
        "; ".join(r.faults()) or "ok",
    )


def _share(rate: Rate) -> str:
    return f"{rate.count}/{rate.of}"


def explain_failures(report: TaskReport) -> None:
    """Play failed tries again, one of each cause, and print what is known of them."""
    for f in report.failures:
        picture = Path("out/explain") / f"{report.task}_{f.seed}_{f.attempt}.png"
        print("\n".join(explain_failure(report.task, f.seed, f.variation, picture, attempt=f.attempt)))


def print_failures(report: TaskReport) -> None:
    """Print why tries failed, most frequent first, with a seed to see it."""
    for f in report.failures:
        where = "" if f.waypoint is None else f", waypoint {f.waypoint}"
        print(
            f"{report.task}: {f.count} x {f.cause}  (first at seed {f.seed}, variation {f.variation}, attempt {f.attempt}{where})"
        )
