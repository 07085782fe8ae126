"""`rlbench-pin problems export TASK...`: write motions of demonstrations as planning problems, one file for each."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import tyro

from rlbench_pin.cli.list_tasks import named_tasks
from rlbench_pin.cli.options import SomeTasks, check_at_least, check_folder, checked_names

if TYPE_CHECKING:
    from rlbench_pin.recording.problems import ProblemRecorder
    from rlbench_pin.tasks import Task


@dataclass(frozen=True)
class Problems:
    """Write motions of demonstrations as planning problems: arm, obstacles, grasped bodies, start and goal, as JSON.

    A problem is a segment that is planned to a pose among obstacles. Segments that ignore collisions (`ignore_collisions`) or
    follow a curve are left out; the last line for each task counts them.
    """

    action: tyro.conf.Positional[Literal["export"]]
    """Subcommand."""
    tasks: tyro.conf.Positional[SomeTasks] = ()
    """Task names, as `rlbench-pin list` prints them, separated by spaces or commas, `all`, or task files."""
    episodes: int = 5
    """Number of demonstrations of each task."""
    seed: int = 0
    """Seed of the first episode; episode i uses seed + i."""
    out: Path = Path("problems")
    """Folder for the files."""

    def run(self) -> int:
        """Write the problems, print the numbers of problems and other segments; return 1 when there is no problem."""
        from rlbench_pin.tasks import find_task

        check_at_least(self, episodes=1, seed=0)
        names = checked_names(self.tasks, named_tasks, "rlbench-pin problems export TASK...")
        tasks = [find_task(name) for name in names]
        check_folder(self.out)
        written = 0
        for task in tasks:
            name, recorder = task.get_name(), self._export(task)
            written += len(recorder.problems)
            left_out = ", ".join(f"{count} {why}" for why, count in recorder.left_out.items())
            print(f"{name}: {len(recorder.problems)} problems in {self.out}" + (f"; left out: {left_out}" if left_out else ""))
        return 0 if written else 1

    def _export(self, chosen: type[Task]) -> ProblemRecorder:
        from rlbench_pin.environment.presets import low_dim_config, make_environment
        from rlbench_pin.planning.problems import write_problem
        from rlbench_pin.recording.problems import ProblemRecorder

        name = chosen.get_name()
        with make_environment(low_dim_config()) as environment:
            task = environment.get_task(chosen)
            recorder = ProblemRecorder()
            with task.runtime.listening(recorder):
                for episode in range(self.episodes):
                    recorder.begin(f"{name}_{self.seed + episode:04d}")
                    task.try_demo(seed=self.seed + episode, variation=episode % task.variation_count(), record=False)
        for problem in recorder.problems:
            write_problem(problem, self.out / f"{problem.name}.json")
        return recorder
