"""`rlbench-pin replay FILE...`: do the recorded actions of stored episodes still reach the goal?"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import tyro

from rlbench_pin.checking.judge import replay_succeeds
from rlbench_pin.datasets import read_demo, stored_tasks
from rlbench_pin.datasets.reader import counted_demo, counted_files
from rlbench_pin.environment import Environment, TaskEnvironment
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.errors import DatasetError
from rlbench_pin.observation import LOW_DIM, Demo


@dataclass(frozen=True)
class Replay:
    """Restore the start of stored episodes, repeat their joint-position actions, and say whether they succeed again."""

    files: tyro.conf.Positional[tuple[Path, ...]]
    """Episode files, or folders of datasets, of which those count that their manifests list."""

    def run(self) -> int:
        """Print one line per episode; 1 when one does not succeed."""
        failed = 0
        with make_environment(low_dim_config()) as environment:
            task: TaskEnvironment | None = None
            for path, demo in _episodes(self.files):
                task = _task(environment, task, demo.task_name)
                task.reset_to_demo(demo)
                succeeds = replay_succeeds(task, demo)
                failed += not succeeds
                print(f"{'reached' if succeeds else 'MISSED '}  {path}")
        print(f"{failed or 'none'} missed the goal")
        return 1 if failed else 0


def _task(environment: Environment, present: TaskEnvironment | None, name: str) -> TaskEnvironment:
    """Return the loop of a task, the present one when it is the same."""
    return present if present is not None and present.get_name() == name else environment.get_task(name)


def _episodes(paths: tuple[Path, ...]) -> Iterator[tuple[Path, Demo]]:
    """Yield episodes and where they lie, each read when its turn comes."""
    for path in paths:
        if not path.is_dir():
            yield path, read_demo(path, LOW_DIM)
            continue
        tasks = stored_tasks(path)
        if not tasks:
            raise DatasetError(f"'{path}' holds no demonstrations. `rlbench-pin record TASK --out {path}` makes some.")
        for task in tasks:
            for file, sha256 in counted_files(path, task).items():
                yield file, counted_demo(file, sha256, LOW_DIM)
