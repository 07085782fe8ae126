"""The sets of tasks by name, as `sets.json` lists them; names of tasks that are not built yet are among them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from rlbench_pin.errors import UnknownName
from rlbench_pin.tasks import task_names
from rlbench_pin.values import as_text

DATA = Path(__file__).with_name("sets.json")
SETS_COMMAND = "rlbench-pin list --sets"
WHOLE = "tasks"
"""The part of a set that has no parts."""


@dataclass(frozen=True)
class TaskSet:
    """Tasks with a name in common."""

    name: str
    """`FS10_V1`, or `FS10_V1:train` for a part of it."""
    about: str
    """What it is, one sentence."""
    tasks: tuple[str, ...]
    """All its tasks, in the order of the public lists; those to train on come first."""
    parts: Mapping[str, tuple[str, ...]]
    """Part -> its tasks: `train` and `test` where there are both, otherwise nothing."""

    @property
    def missing(self) -> tuple[str, ...]:
        """Names of the tasks that are not built yet."""
        built = set(task_names())
        return tuple(name for name in self.tasks if name not in built)

    @property
    def available(self) -> tuple[str, ...]:
        """Names of the tasks that are there."""
        built = set(task_names())
        return tuple(name for name in self.tasks if name in built)


def task_sets() -> tuple[str, ...]:
    """Return the names of all sets; `:train` and `:test` behind those with two parts stand for these."""
    return tuple(set_contents())


def task_set(name: str) -> TaskSet:
    """Return a set, or a part of one.

    Args:
        name: `FS10_V1`, `FS10_V1:train`, `FS10_V1:test`, `MT15_V1`, `PERACT18`, `tier1`, ...

    Raises:
        UnknownName: No set is called so, or it has no such part; proposes the nearest name.
    """
    contents = set_contents()
    known = (*contents, *(f"{s}:{part}" for s, held in contents.items() if len(held.parts) > 1 for part in held.parts))
    if not isinstance(name, str) or name not in known:
        raise UnknownName("set of tasks", name, known, SETS_COMMAND)
    whole, _, part = name.partition(":")
    if not part:
        return contents[whole]
    return TaskSet(name, f"{contents[whole].about} The part `{part}`.", contents[whole].parts[part], {})


def public_tasks() -> tuple[str, ...]:
    """Return the names of the 106 tasks of the public task set, in alphabetical order, built or not."""
    return _names("public")


def variant_tasks() -> tuple[str, ...]:
    """Return the names of the tasks that the PerAct dialect adds to them."""
    return _names("variants")


def task_tier(task: str) -> int:
    """Return how hard a public task is: 1 one motion, 2 one object or joint, 3 several stages, 4 long, precise or with tools.

    Raises:
        UnknownName: It is none of the 106 public tasks, which alone have a tier.
    """
    as_text(task, "task")
    for tier in range(1, 5):
        if task in set_contents()[f"tier{tier}"].tasks:
            return tier
    raise UnknownName("task with a tier", task, public_tasks(), SETS_COMMAND)


@lru_cache(maxsize=1)
def set_contents() -> dict[str, TaskSet]:
    """Return name -> set, as the file has them."""
    found = {}
    for name, content in _data()["sets"].items():
        parts = {part: tuple(names) for part, names in content.items() if part != "about"}
        tasks = tuple(task for names in parts.values() for task in names)
        found[name] = TaskSet(name, content["about"], tasks, {} if WHOLE in parts else parts)
    return found


def _names(key: str) -> tuple[str, ...]:
    return tuple(_data()[key])


@lru_cache(maxsize=1)
def _data() -> dict[str, Any]:
    content: dict[str, Any] = json.loads(DATA.read_text(encoding="utf-8"))
    return content
