"""Sets of tasks by name: few-shot and multi-task sets, PerAct's 18, tiers; and which tasks some words stand for."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.evaluation.sets.catalogue import TaskSet, public_tasks, task_set, task_sets, task_tier, variant_tasks
from rlbench_pin.evaluation.sets.selection import TaskSelection, resolve_tasks, select_tasks
from rlbench_pin.front_door import front_door

__all__ = [
    "TaskSelection",
    "TaskSet",
    "public_tasks",
    "resolve_tasks",
    "select_tasks",
    "task_set",
    "task_sets",
    "task_tier",
    "variant_tasks",
]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
