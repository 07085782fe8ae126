"""`rlbench-pin replay FILE...`: check that the recorded actions of stored episodes still reach the goal."""

from __future__ import annotations

from dataclasses import dataclass

import tyro

from rlbench_pin.cli.options import Files, SomeFiles
from rlbench_pin.errors import DatasetError, TaskEnvironmentError


@dataclass(frozen=True)
class Replay:
    """Restore the start of stored episodes, repeat their joint-position actions, and print whether they succeed again."""

    files: tyro.conf.Positional[SomeFiles] = ()
    """Episode files, or folders of datasets. All episodes in the manifests of a dataset are replayed."""

    task_file: Files = ()
    """Your own task files for tasks that are not installed; they replace those in the dataset."""
    trust_task_files: bool = False
    """Run the task files in the dataset, for tasks that are not installed. Read them first."""

    def run(self) -> int:
        """Print one line per episode; return 1 when one does not succeed."""
        from rlbench_pin.recording.replay import replay_stored
        from rlbench_pin.tasks import own_tasks

        if not self.files:
            raise TaskEnvironmentError(
                "No episode was named. Use `rlbench-pin replay FILE...` with files or folders of datasets."
            )
        replayed = failed = 0
        for result in replay_stored(self.files, own=own_tasks(self.task_file), trust_task_files=self.trust_task_files):
            replayed += 1
            failed += not result.reached
            print(f"{'reached' if result.reached else 'MISSED '}  {result.path}")
        if not replayed:
            raise DatasetError(
                f"There are no episodes in {', '.join(map(str, self.files))}. Record some with `rlbench-pin record TASK`."
            )
        print(f"{failed or 'none'} of {replayed} missed the goal")
        return 1 if failed else 0
