"""Task names and task sets of RLBench, and the classes of our library for them."""

from __future__ import annotations

from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.evaluation.sets import public_tasks, task_set, variant_tasks
from rlbench_pin.tasks import Task, task_class, task_names

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
"""Name of the set -> `train` and, in few-shot sets, `test` -> names of tasks, built or not."""


class MissingTask(RlbenchPinError, NotImplementedError):
    """A task of the public task set that our library does not have yet; `name` is its name."""

    def __init__(self, name: str) -> None:
        self.name = name
        super().__init__(
            f"The task '{name}' belongs to RLBench, but is not in the library of rlbench_pin yet, which has {len(task_names())} "
            "tasks. `rlbench-pin list` prints them; os.listdir(rlbench.backend.task.TASKS_PATH) lists their files."
        )


def check_present(name: str) -> None:
    """Raise MissingTask unless the library has a task of that name."""
    if name not in task_names():
        raise MissingTask(name)


def library_task(name: str) -> type[Task]:
    """Return the class of a task of our library, or raise MissingTask."""
    check_present(name)
    return task_class(name)


def all_tasks() -> tuple[str, ...]:
    """Return all names of tasks that programs may use: the public set, PerAct's, and the further tasks of our library."""
    return tuple(sorted({*KNOWN_TASKS, *PERACT_TASKS, *task_names()}))
