"""`rlbench-pin problems export TASK...`: every leg of a task's demonstrations as a planning problem in a file of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tyro

from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.planning.planner import MotionPlanner, Plan
from rlbench_pin.planning.problems.problem import PlanningProblem, write_problem
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.spatial import FloatArray, PoseLike
from rlbench_pin.tasks import task_class


@dataclass(frozen=True)
class Problems:
    """Write the legs of demonstrations as planning problems: arm, obstacles, held bodies, start and goal, as JSON."""

    action: tyro.conf.Positional[str]
    """What to do: `export`."""
    tasks: tyro.conf.Positional[tuple[str, ...]]
    """Task names, as `rlbench-pin list` prints them."""
    episodes: int = 5
    """Demonstrations of each task."""
    seed: int = 0
    """Seed of the first episode; episode i uses seed + i."""
    out: Path = Path("problems")
    """Folder for the files."""

    def run(self) -> int:
        """Play demonstrations, write their legs, print how many; 2 when misused."""
        if self.action != "export" or not self.tasks:
            print("rlbench-pin: use `rlbench-pin problems export TASK...`")
            return 2
        for name in [task_class(name).get_name() for name in self.tasks]:
            count = self._export(name)
            print(f"{name}: {count} problems in {self.out}")
        return 0

    def _export(self, name: str) -> int:
        with make_environment(low_dim_config()) as environment:
            task = environment.get_task(name)
            recorder = LegRecorder(task.runtime.planner)
            for episode in range(self.episodes):
                recorder.prefix = f"{name}_{self.seed + episode:04d}"
                task.try_demo(seed=self.seed + episode, variation=episode % task.variation_count(), record=False)
        for problem in recorder.problems:
            write_problem(problem, self.out / f"{problem.name}.json")
        return len(recorder.problems)


class LegRecorder:
    """Looks over a planner's shoulder: keeps every leg that it plans as a problem."""

    def __init__(self, planner: MotionPlanner) -> None:
        self.problems: list[PlanningProblem] = []
        self.prefix = ""
        self._update, self._plan = planner.update, planner.plan_to_pose
        self._world: WorldSnapshot | None = None
        planner.update = self.update  # type: ignore[method-assign]
        planner.plan_to_pose = self.plan_to_pose  # type: ignore[method-assign, assignment]

    def update(self, snapshot: WorldSnapshot) -> None:
        """Remember the world."""
        self._world = snapshot
        self._update(snapshot)

    def plan_to_pose(self, q_start: FloatArray, pose: PoseLike | Sequence[PoseLike], **options: object) -> Plan:
        """Plan, and keep what was asked."""
        plan = self._plan(q_start, pose, **options)  # type: ignore[arg-type]
        if not options.get("ignore_collisions") and self._world is not None:
            world = WorldSnapshot(self._world.bodies, np.array(q_start), self._world.fingers, self._world.attached)
            leg = sum(p.name.startswith(self.prefix) for p in self.problems)
            self.problems.append(
                PlanningProblem(
                    f"{self.prefix}_leg{leg}", world, plan.trajectory.q[-1].copy(), np.atleast_2d(np.asarray(pose, dtype=float)),
                    tuple(options.get("allowed", ())),  # type: ignore[arg-type]
                )
            )  # fmt: skip
        return plan
