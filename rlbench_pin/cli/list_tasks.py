"""`rlbench-pin list`: the tasks; and the task names in the arguments of other commands."""

from __future__ import annotations

import inspect
import json
import os.path
import sys
from collections.abc import Iterable
from dataclasses import dataclass

ALL = "all"
"""Name of all tasks on a command line."""


@dataclass(frozen=True)
class ListTasks:
    """List the tasks, each with one line of description.

    Those of other packages come last, with the name of the package.
    """

    sets: bool = False
    """List the sets of tasks instead, each with how many of its tasks are built."""
    json: bool = False
    """Print JSON for programs."""

    def run(self) -> int:
        """Print one line per task, or per set."""
        from rlbench_pin.tasks import task_origin

        if self.sets:
            return self.print_sets()
        titles = {name: _title(name) for name in usable_names()}
        if self.json:
            print(json.dumps(titles, indent=1))
            return 0
        width = max(map(len, titles), default=0)
        for name, title in titles.items():
            origin = task_origin(name)
            print(f"{name:<{width}}  {title}" + (f"  [{origin}]" if origin else ""))
        return 0

    def print_sets(self) -> int:
        """Print one line per set; as JSON, all data of each."""
        from rlbench_pin.evaluation.sets import task_set, task_sets

        sets = [task_set(name) for name in task_sets()]
        if self.json:
            content = {s.name: {"about": s.about, "tasks": s.tasks, "parts": s.parts, "missing": s.missing} for s in sets}
            print(json.dumps(content, indent=1))
            return 0
        width = max(len(s.name) for s in sets)
        for s in sets:
            print(f"{s.name:<{width}}  {len(s.available):>3} of {len(s.tasks):>3} built  {s.about}")
        print("`FS10_V1:train` and `FS10_V1:test` are the parts of a set. `--json` names the tasks, and those that are missing.")
        return 0


def split_names(words: Iterable[str]) -> tuple[str, ...]:
    """Return the names in `words`, each once, in order; `a,b` is two names, unless there is a file of that name."""
    parts = [part.strip() for word in words for part in ([word] if os.path.isfile(word) else word.split(","))]
    return tuple(dict.fromkeys(part for part in parts if part))


def named_tasks(words: Iterable[str]) -> tuple[str, ...]:
    """Return the names in `words`, each once, in order; `all` is replaced by the names of all tasks."""
    names = (usable_names() if name == ALL else (name,) for name in split_names(words))
    return tuple(dict.fromkeys(name for some in names for name in some))


def usable_names() -> tuple[str, ...]:
    """Return the names of all tasks but those of broken packages, each of which is reported on stderr."""
    from rlbench_pin.tasks import plugin_faults, usable_task_names

    for fault in plugin_faults().values():
        print(f"rlbench-pin: {fault}", file=sys.stderr)
    return usable_task_names()


def _title(name: str) -> str:
    """Return the first line of the docstring of a task's module."""
    from rlbench_pin.tasks import task_class

    module = inspect.getmodule(task_class(name))
    return (inspect.getdoc(module) or "").split("\n")[0]
