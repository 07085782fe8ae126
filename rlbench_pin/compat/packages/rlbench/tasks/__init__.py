"""The tasks by name: `ReachTarget` and the others, `rlbench.tasks.reach_target` and the others, and the task sets.

All names of the public task set are there, each in a file of its own, so that `importlib.reload` and tools that list modules
work. A task that our library does not have yet says so when it is made or loaded. A file is read when its name is first used.
"""

from __future__ import annotations

import importlib
from types import ModuleType

from rlbench.backend.task import Task
from rlbench_pin.compat.tasks.library import KNOWN_TASKS, PERACT_TASKS, all_tasks
from rlbench_pin.compat.tasks.sets import TASK_SETS
from rlbench_pin.errors import nearest_name
from rlbench_pin.tasks import camel_case

_HOMES = {camel_case(name): name for name in all_tasks()}

__all__ = sorted([*_HOMES, *TASK_SETS])

TaskSet = dict[str, list[type[Task]]]


def _task(name: str) -> type[Task]:
    found: type[Task] = getattr(importlib.import_module(f"{__name__}.{name}"), camel_case(name))
    return found


def __getattr__(name: str) -> type[Task] | TaskSet | ModuleType:
    """Read the file of a task, or make a task set, when its name is first used; say which name is near when there is none."""
    value: type[Task] | TaskSet | ModuleType
    if name in _HOMES:
        value = _task(_HOMES[name])
    elif name in TASK_SETS:
        value = {part: [_task(task) for task in names] for part, names in TASK_SETS[name].items()}
    elif name in _HOMES.values():
        return importlib.import_module(f"{__name__}.{name}")
    else:
        near = nearest_name(name, __all__)
        guess = f" Did you mean '{near}'?" if near else ""
        known = f"{len(KNOWN_TASKS)} tasks, {len(PERACT_TASKS)} more of PerAct's, and {len(TASK_SETS)} task sets"
        raise AttributeError(f"module '{__name__}' has no attribute '{name}': it has {known}.{guess}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """List the public names, read or not."""
    return sorted({*globals(), *__all__})
