"""`rlbench-pin replay FILE...`: do the recorded actions of stored episodes still reach the goal?"""

from __future__ import annotations

from rlbench_pin.cli.arguments import replay as arguments
from rlbench_pin.errors import DatasetError, TaskEnvironmentError
from rlbench_pin.recording.replay import replay_stored
from rlbench_pin.tasks import own_tasks


class Replay(arguments.Replay):
    """The work of `rlbench-pin replay`."""

    def run(self) -> int:
        """Print one line per episode; 1 when one does not succeed."""
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
            raise DatasetError(f"There are no episodes in {', '.join(map(str, self.files))}. `rlbench-pin record` makes some.")
        print(f"{failed or 'none'} of {replayed} missed the goal")
        return 1 if failed else 0
