"""Motions of demonstrations as planning problems."""

from __future__ import annotations

from collections import Counter

import numpy as np

from rlbench_pin.environment.runtime import Listener
from rlbench_pin.errors import PlanningError
from rlbench_pin.planning.plan import Plan, PlanRequest
from rlbench_pin.planning.problems import PlanningProblem
from rlbench_pin.scene.snapshot import WorldSnapshot


class ProblemRecorder(Listener):
    """Collects planning problems: every motion that is planned to a tip pose among obstacles.

    Attributes:
        problems: The problems so far.
        left_out: Reason -> number of planned motions that are not problems for this reason.
    """

    def __init__(self) -> None:
        self.problems: list[PlanningProblem] = []
        self.left_out: Counter[str] = Counter()
        self._prefix, self._segments = "", 0
        self._world: WorldSnapshot | None = None

    def begin(self, prefix: str) -> None:
        """Begin an episode: its problems are called `<prefix>_segment0`, `<prefix>_segment1` and so on."""
        self._prefix, self._segments = prefix, 0

    def on_update(self, snapshot: WorldSnapshot, seconds: float) -> None:
        """Keep the snapshot of the world."""
        self._world = snapshot

    def on_plan(self, request: PlanRequest, outcome: Plan | PlanningError, seconds: float) -> None:
        """Keep the request, with the end of the plan as the goal."""
        if isinstance(outcome, PlanningError) or request.kind == "configuration" or self._world is None:
            return
        if request.kind == "curve" or request.ignore_collisions:
            self.left_out["along curves" if request.kind == "curve" else "that ignore collisions"] += 1
            return
        world = WorldSnapshot(self._world.bodies, np.array(request.q_start), self._world.fingers, self._world.attached)
        poses = np.atleast_2d(np.asarray(request.goal, dtype=float))
        goal = outcome.trajectory.q[-1].copy()
        self.problems.append(PlanningProblem(f"{self._prefix}_segment{self._segments}", world, goal, poses, request.allowed))
        self._segments += 1
