"""The tasks by name: `ReachTarget` and the others, `rlbench.tasks.reach_target` and the others, and the task sets.

All names of the public task set are there. A task that our library does not have yet says so when it is made or loaded.
Nothing of a task's own is imported before it is used.
"""

from __future__ import annotations

import sys
from importlib.machinery import ModuleSpec
from types import ModuleType

from rlbench.backend.task import Task
from rlbench_pin.compat.tasks.library import KNOWN_TASKS, PERACT_TASKS, all_tasks
from rlbench_pin.compat.tasks.sets import TASK_SETS
from rlbench_pin.errors import nearest_name
from rlbench_pin.tasks import LIBRARY, camel_case


def task_module(name: str) -> ModuleType:
    """Return the module `rlbench.tasks.<name>` with the class of one task."""
    module = ModuleType(f"{__name__}.{name}", f"The task `{name}` of our library, under its known name.")
    title = camel_case(name)
    namespace = {"library_name": name, "__module__": module.__name__, "__qualname__": title, "__doc__": f"The task `{name}`."}
    module.__file__ = str(LIBRARY / f"{name}.py")
    module.__package__ = __name__
    module.__spec__ = ModuleSpec(module.__name__, None, origin=module.__file__)
    vars(module).update({title: type(title, (Task,), namespace), "Task": Task})
    return module


_modules = {name: task_module(name) for name in all_tasks()}
_classes: dict[str, type[Task]] = {camel_case(name): vars(module)[camel_case(name)] for name, module in _modules.items()}
_sets: dict[str, dict[str, list[type[Task]]]] = {
    title: {part: [_classes[camel_case(name)] for name in names] for part, names in parts.items()}
    for title, parts in TASK_SETS.items()
}
sys.modules.update({module.__name__: module for module in _modules.values()})
globals().update({**_modules, **_classes, **_sets})

__all__ = sorted([*_classes, *_sets])


def __getattr__(name: str) -> type[Task]:
    """Say which task is nearest to a name that nobody has."""
    near = nearest_name(name, __all__)
    guess = f" Did you mean '{near}'?" if near else ""
    known = f"{len(KNOWN_TASKS)} tasks, {len(PERACT_TASKS)} more of PerAct's, and {len(_sets)} task sets"
    raise AttributeError(f"module '{__name__}' has no attribute '{name}': it has {known}.{guess}")
