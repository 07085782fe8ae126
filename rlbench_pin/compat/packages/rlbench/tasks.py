"""Task classes such as `ReachTarget`, modules of tasks such as `rlbench.tasks.reach_target`, and task sets.

The modules of tasks, which programs import, reload and list, are aliases of this module, so that `importlib.reload` finds a
file.
"""

from __future__ import annotations

from typing import Any

from rlbench.backend.task import TASKS_PATH, Task
from rlbench_pin.compat import add_aliases
from rlbench_pin.compat.known_tasks import KNOWN_TASKS, PERACT_TASKS, TASK_SETS, all_tasks
from rlbench_pin.errors import nearest_name
from rlbench_pin.tasks import camel_case


def _task_class(name: str) -> type[Task]:
    """Return RLBench's class of a library task."""
    text = f"The task `{name}` of our library."
    return type(camel_case(name), (Task,), {"__module__": f"{__name__}.{name}", "__doc__": text, "library_name": name})


_CLASSES = {name: _task_class(name) for name in all_tasks()}
_SETS = {name: {part: [_CLASSES[task] for task in tasks] for part, tasks in parts.items()} for name, parts in TASK_SETS.items()}

globals().update({cls.__name__: cls for cls in _CLASSES.values()}, **_SETS)
add_aliases(__name__, _CLASSES)

__path__ = [TASKS_PATH]  # for `pkgutil.iter_modules`
__all__ = sorted([*(cls.__name__ for cls in _CLASSES.values()), *_SETS])


def __getattr__(name: str) -> Any:
    """Raise an error that proposes the nearest name."""
    near = nearest_name(name, __all__)
    guess = f" Did you mean '{near}'?" if near else ""
    known = f"{len(KNOWN_TASKS)} tasks, {len(PERACT_TASKS)} more of PerAct's, and {len(_SETS)} task sets"
    raise AttributeError(f"module '{__name__}' has no attribute '{name}': it has {known}.{guess}")
