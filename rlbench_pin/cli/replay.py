"""`rlbench-pin replay FILE...`: do the recorded actions of stored episodes still reach the goal?"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import tyro

from rlbench_pin.recording.replay_stored import replay_stored
from rlbench_pin.tasks import own_tasks


@dataclass(frozen=True)
class Replay:
    """Restore the start of stored episodes, repeat their joint-position actions, and say whether they succeed again."""

    files: tyro.conf.Positional[tuple[Path, ...]]
    """Episode files, or folders of datasets, of which the episodes in the manifests are replayed."""

    task_file: tuple[Path, ...] = ()
    """Your own files of tasks that are not installed; they are used instead of those that the dataset keeps."""
    trust_task_files: bool = False
    """Run the task files that the dataset keeps, where tasks are not installed. Read them first."""

    def run(self) -> int:
        """Print one line per episode; 1 when one does not succeed."""
        failed = 0
        for result in replay_stored(self.files, own=own_tasks(self.task_file), trust_task_files=self.trust_task_files):
            failed += not result.reached
            print(f"{'reached' if result.reached else 'MISSED '}  {result.path}")
        print(f"{failed or 'none'} missed the goal")
        return 1 if failed else 0
