"""`rlbench-pin problems export TASK...`: motions of demonstrations as planning problems, each in a file of its own."""

from __future__ import annotations

from collections import Counter

import numpy as np

from rlbench_pin.cli.arguments import problems as arguments
from rlbench_pin.cli.list_tasks import named_tasks
from rlbench_pin.cli.process.files import check_folder
from rlbench_pin.cli.process.words import check_at_least, checked_names
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.environment.runtime import Listener
from rlbench_pin.errors import PlanningError
from rlbench_pin.planning.listener import PlanRequest
from rlbench_pin.planning.plan import Plan
from rlbench_pin.planning.problems import PlanningProblem, write_problem
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.tasks import Task, find_task


class Problems(arguments.Problems):
    """The work of `rlbench-pin problems`."""

    def run(self) -> int:
        """Play demonstrations, write their legs, print how many, and how many are no problems; 1 when there is no problem."""
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


class ProblemRecorder(Listener):
    """Keeps every motion that is planned to a tip pose among obstacles as a planning problem.

    Attributes:
        problems: What was planned so far.
        left_out: Why motions that were planned are no problems -> how many.
    """

    def __init__(self) -> None:
        self.problems: list[PlanningProblem] = []
        self.left_out: Counter[str] = Counter()
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
        if isinstance(outcome, PlanningError) or request.kind == "configuration" or self._world is None:
            return
        if request.kind == "curve" or request.ignore_collisions:
            self.left_out["along curves" if request.kind == "curve" else "that may touch anything"] += 1
            return
        world = WorldSnapshot(self._world.bodies, np.array(request.q_start), self._world.fingers, self._world.attached)
        poses = np.atleast_2d(np.asarray(request.goal, dtype=float))
        goal = outcome.trajectory.q[-1].copy()
        self.problems.append(PlanningProblem(f"{self._prefix}_leg{self._legs}", world, goal, poses, request.allowed))
        self._legs += 1
