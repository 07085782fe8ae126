"""Task names and task sets of RLBench."""

from __future__ import annotations

from rlbench_pin.evaluation.sets import public_tasks, task_set, variant_tasks
from rlbench_pin.tasks import task_names

KNOWN_TASKS: tuple[str, ...] = public_tasks()
"""The 106 tasks of the public task set."""

PERACT_TASKS: tuple[str, ...] = variant_tasks()
"""Tasks that the PerAct dialect adds."""

_SPLIT = ("FS10_V1", "FS25_V1", "FS50_V1", "FS95_V1")
_WHOLE = ("MT15_V1", "MT30_V1", "MT55_V1", "MT100_V1")

TASK_SETS: dict[str, dict[str, tuple[str, ...]]] = {
    **{name: dict(task_set(name).parts) for name in _SPLIT},
    **{name: {"train": task_set(name).tasks} for name in _WHOLE},
}
"""Name of the set -> `train` and, in few-shot sets, `test` -> names of tasks."""


def all_tasks() -> tuple[str, ...]:
    """Return the names of all tasks that programs can use: the public set, those of PerAct, and the rest of our library."""
    return tuple(sorted({*KNOWN_TASKS, *PERACT_TASKS, *task_names()}))
