"""`rlbench-pin evaluate --controllers`: every controller follows the legs that demonstrations plan."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from tqdm import tqdm

from rlbench_pin.cli.list_tasks import named_tasks
from rlbench_pin.cli.process.files import check_file, write_json
from rlbench_pin.cli.process.words import check_at_least, checked_names
from rlbench_pin.environment.demos import library_versions
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.errors import TaskEnvironmentError
from rlbench_pin.evaluation.controllers.summary import ControllerSummary, summarise_legs, table
from rlbench_pin.evaluation.controllers.trials import LegTrial, chosen_controllers, follow_demo
from rlbench_pin.tasks import find_task


@dataclass(frozen=True)
class ControllerComparison:
    """Controllers on the legs of demonstrations."""

    tasks: tuple[str, ...]
    """Task names, or task files."""
    episodes: int = 1
    """Demonstrations of each task."""
    seed: int = 0
    """Seed of the first episode; episode i uses seed + i."""
    legs: int | None = None
    """Number of legs of each demonstration; all when None."""
    only: tuple[str, ...] = ()
    """Controllers to compare; all when none is given."""
    json: Path | None = None
    """File to write everything to."""

    def run(self) -> int:
        """Follow, and print one table per kind of leg."""
        check_at_least(self, episodes=1, seed=0, legs=1)
        checked_names(self.tasks, named_tasks, "rlbench-pin evaluate --controllers --tasks TASK...")
        chosen_controllers(self.only)
        if self.json is not None:
            check_file(self.json)
        trials = list(self.trials())
        if not trials:
            raise TaskEnvironmentError("No leg was planned, so there is nothing to compare. Name other tasks.")
        summaries = summarise_legs(trials)
        print(report(summaries))
        if self.json is not None:
            write_json(self.json, self.content(summaries))
        return 0

    def content(self, summaries: Sequence[ControllerSummary]) -> dict[str, object]:
        """Return what the JSON file says."""
        return {
            "format": 1,
            "tasks": list(named_tasks(self.tasks)),
            "episodes": self.episodes,
            "seed": self.seed,
            "legs": self.legs,
            "versions": library_versions(),
            "controllers": [asdict(s) for s in summaries],
        }

    def trials(self) -> Iterator[LegTrial]:
        """Let every controller follow every leg."""
        names = chosen_controllers(self.only)
        classes = [find_task(name) for name in named_tasks(self.tasks)]
        with tqdm(total=len(classes) * self.episodes, unit="episode", desc="controllers") as bar:
            for task_class in classes:
                with make_environment(low_dim_config()) as environment:
                    task = environment.get_task(task_class)
                    for seed in range(self.seed, self.seed + self.episodes):
                        yield from follow_demo(task, seed, names, self.legs)
                        bar.update()


def report(summaries: Sequence[ControllerSummary], title: str = "") -> str:
    """Return one table per kind of leg under its heading; `title` stands before each heading."""
    headings = {"free": "Legs planned around obstacles", "contact": "Legs that may touch"}
    parts = [(heading, [s for s in summaries if s.kind == kind]) for kind, heading in headings.items()]
    return "\n\n".join(f"{title}{heading}\n\n{table(rows)}" for heading, rows in parts if rows)
