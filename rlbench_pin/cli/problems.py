"""`rlbench-pin problems export TASK...`: every leg of a task's demonstrations as a planning problem in a file of its own."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tyro

from rlbench_pin.cli.list_tasks import named_tasks
from rlbench_pin.environment.listener import Listener
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.errors import PlanningError
from rlbench_pin.planning.listener import PlanRequest
from rlbench_pin.planning.plan import Plan
from rlbench_pin.planning.problems.problem import PlanningProblem, write_problem
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.tasks import task_class


@dataclass(frozen=True)
class Problems:
    """Write motions of demonstrations as planning problems: arm, obstacles, held bodies, start and goal, as JSON."""

    action: tyro.conf.Positional[str]
    """What to do: `export`."""
    tasks: tyro.conf.Positional[tuple[str, ...]]
    """Task names, as `rlbench-pin list` prints them, with spaces or commas between them, or `all`."""
    episodes: int = 5
    """Demonstrations of each task."""
    seed: int = 0
    """Seed of the first episode; episode i uses seed + i."""
    out: Path = Path("problems")
    """Folder for the files."""

    def run(self) -> int:
        """Play demonstrations, write their legs, print how many; 2 when misused."""
        names = named_tasks(self.tasks)
        if self.action != "export" or not names:
            print("rlbench-pin: use `rlbench-pin problems export TASK...`", file=sys.stderr)
            return 2
        for name in [task_class(name).get_name() for name in names]:
            count = self._export(name)
            print(f"{name}: {count} problems in {self.out}")
        return 0

    def _export(self, name: str) -> int:
        with make_environment(low_dim_config()) as environment:
            task = environment.get_task(name)
            recorder = ProblemRecorder()
            with task.runtime.listening(recorder):
                for episode in range(self.episodes):
                    recorder.begin(f"{name}_{self.seed + episode:04d}")
                    task.try_demo(seed=self.seed + episode, variation=episode % task.variation_count(), record=False)
        for problem in recorder.problems:
            write_problem(problem, self.out / f"{problem.name}.json")
        return len(recorder.problems)


class ProblemRecorder(Listener):
    """Keeps every motion that is planned to a tip pose among obstacles as a planning problem.

    Attributes:
        problems: What was planned so far.
    """

    def __init__(self) -> None:
        self.problems: list[PlanningProblem] = []
        self._prefix, self._legs = "", 0
        self._world: WorldSnapshot | None = None

    def begin(self, prefix: str) -> None:
        """Begin an episode: its problems are called `<prefix>_leg0`, `<prefix>_leg1` and so on."""
        self._prefix, self._legs = prefix, 0

    def on_update(self, snapshot: WorldSnapshot, seconds: float) -> None:
        """Remember the world."""
        self._world = snapshot

    def on_plan(self, request: PlanRequest, outcome: Plan | PlanningError, seconds: float) -> None:
        """Keep what was asked for, and where the plan ends as the goal."""
        if isinstance(outcome, PlanningError) or request.kind != "pose" or request.ignore_collisions or self._world is None:
            return
        world = WorldSnapshot(self._world.bodies, np.array(request.q_start), self._world.fingers, self._world.attached)
        poses = np.atleast_2d(np.asarray(request.goal, dtype=float))
        goal = outcome.trajectory.q[-1].copy()
        self.problems.append(PlanningProblem(f"{self._prefix}_leg{self._legs}", world, goal, poses, request.allowed))
        self._legs += 1
