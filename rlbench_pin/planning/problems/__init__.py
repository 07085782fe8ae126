"""Planning problems as files."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.front_door import front_door
from rlbench_pin.planning.problems.motion_bench import read_motion_bench
from rlbench_pin.planning.problems.problem import PlanningProblem, read_problem, self_contained, solid_body, write_problem

__all__ = [
    "PlanningProblem",
    "read_motion_bench",
    "read_problem",
    "self_contained",
    "solid_body",
    "write_problem",
]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
