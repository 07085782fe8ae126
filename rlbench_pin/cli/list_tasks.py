"""`rlbench-pin list`: which tasks there are."""

from __future__ import annotations

import inspect
import json
from dataclasses import dataclass

from rlbench_pin.tasks import task_class, task_names


@dataclass(frozen=True)
class ListTasks:
    """List the tasks, each with a line about it."""

    json: bool = False
    """Print JSON for programs."""

    def run(self) -> int:
        """Print one line per task."""
        titles = {name: _title(name) for name in task_names()}
        if self.json:
            print(json.dumps(titles, indent=1))
            return 0
        width = max(map(len, titles), default=0)
        for name, title in titles.items():
            print(f"{name:<{width}}  {title}")
        return 0


def _title(name: str) -> str:
    """Return the first line of the docstring of a task's module."""
    module = inspect.getmodule(task_class(name))
    return (inspect.getdoc(module) or "").split("\n")[0]
