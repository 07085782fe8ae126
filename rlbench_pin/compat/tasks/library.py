"""The task names that users of RLBench know, and the classes of our library behind them."""

from __future__ import annotations

from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.evaluation.sets import public_tasks, variant_tasks
from rlbench_pin.tasks import Task, task_class, task_names

KNOWN_TASKS: tuple[str, ...] = public_tasks()
"""The 106 tasks of the public task set."""

PERACT_TASKS: tuple[str, ...] = variant_tasks()
"""Tasks that the PerAct dialect adds."""


class MissingTask(RlbenchPinError, NotImplementedError):
    """A task of the public task set that our library does not have yet; `name` is its name."""

    def __init__(self, name: str) -> None:
        self.name = name
        super().__init__(
            f"The task '{name}' is known by name, but it is not in the library of rlbench_pin yet, which has {len(task_names())} "
            "tasks. `rlbench-pin list` prints them; os.listdir(rlbench.backend.task.TASKS_PATH) lists their files."
        )


def library_task(name: str) -> type[Task]:
    """Return the class of a task of our library.

    Raises:
        MissingTask: The library has no task of that name yet.
    """
    if name not in task_names():
        raise MissingTask(name)
    return task_class(name)


def check_present(name: str) -> None:
    """Raise MissingTask unless the library has a task of that name."""
    if name not in task_names():
        raise MissingTask(name)


def all_tasks() -> tuple[str, ...]:
    """Return all names that programs may ask for: the public set, PerAct's, and what our library has besides."""
    return tuple(sorted({*KNOWN_TASKS, *PERACT_TASKS, *task_names()}))
