"""Named sets of tasks: few-shot and multi-task sets, sets of published protocols, tiers and families. `sets.json` lists them."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from rlbench_pin.errors import UnknownName
from rlbench_pin.tasks import find_task, task_class, task_names, usable_task_names
from rlbench_pin.tasks.task import snake_case
from rlbench_pin.values import as_names, as_text

__all__ = [
    "TaskSet",
    "gembench_tasks",
    "public_tasks",
    "resolve_tasks",
    "task_families",
    "task_set",
    "task_sets",
    "task_tier",
    "variant_tasks",
]

DATA = Path(__file__).with_name("sets.json")
SETS_COMMAND = "rlbench-pin list --sets"
_COMMAND = "rlbench-pin list [--sets]"
ALL = "all"
"""Selects all tasks."""
WHOLE = "tasks"
"""Name of the only part of a set without parts."""


@dataclass(frozen=True)
class TaskSet:
    """A named set of tasks."""

    name: str
    """`FS10_V1`, or `FS10_V1:train` for a part of it."""
    about: str
    """Description, one sentence."""
    tasks: tuple[str, ...]
    """All its tasks, in the order of the public lists; training tasks come first."""
    parts: Mapping[str, tuple[str, ...]]
    """Part, such as `train` and `test` -> its tasks; empty for a set without parts."""
    notes: str = ""
    """Origin of the set."""


def task_sets() -> tuple[str, ...]:
    """Return the names of all sets; `:train` and `:test` select a part of those with two parts."""
    return tuple(set_contents())


def task_set(name: str) -> TaskSet:
    """Return a set, or a part of one.

    Args:
        name: `FS10_V1`, `FS10_V1:train`, `FS10_V1:test`, `MT15_V1`, `PERACT18`, `tier1`, `doors`, ...

    Raises:
        UnknownName: No set has this name, or the set has no such part; proposes the nearest name.
    """
    contents = set_contents()
    known = (*contents, *(f"{s}:{part}" for s, held in contents.items() if len(held.parts) > 1 for part in held.parts))
    if not isinstance(name, str) or name not in known:
        raise UnknownName("set of tasks", name, known, SETS_COMMAND)
    whole, _, part = name.partition(":")
    if not part:
        return contents[whole]
    return TaskSet(name, f"{contents[whole].about} The part `{part}`.", contents[whole].parts[part], {}, contents[whole].notes)


def public_tasks() -> tuple[str, ...]:
    """Return the names of the 106 tasks of the public task set, in alphabetical order."""
    return tuple(_data()["public"])


def variant_tasks() -> tuple[str, ...]:
    """Return the names of the tasks that the PerAct dialect adds to the public tasks."""
    return tuple(_data()["variants"])


def gembench_tasks() -> tuple[str, ...]:
    """Return the names of the tasks that GemBench adds to the public tasks, in alphabetical order."""
    return tuple(_data()["gembench"])


def task_families() -> tuple[str, ...]:
    """Return the names of the families, which group tasks by their kind of manipulation; each task is in one family."""
    return tuple(_data()["families"])


def task_tier(task: str) -> int:
    """Return the tier of a public task: 1 one motion, 2 one object or joint, 3 several stages, 4 long, precise or with tools.

    Raises:
        UnknownName: It is not one of the 106 public tasks; only these have a tier.
    """
    as_text(task, "task")
    for tier in range(1, 5):
        if task in set_contents()[f"tier{tier}"].tasks:
            return tier
    raise UnknownName("task with a tier", task, public_tasks(), SETS_COMMAND)


@lru_cache(maxsize=1)
def set_contents() -> dict[str, TaskSet]:
    """Return name -> set, in the order of the file."""
    found = {}
    for name, content in (*_data()["sets"].items(), *_data()["families"].items()):
        parts = {part: tuple(names) for part, names in content.items() if part not in ("about", "notes")}
        tasks = tuple(task for names in parts.values() for task in names)
        found[name] = TaskSet(name, content["about"], tasks, {} if WHOLE in parts else parts, content["notes"])
    return found


@lru_cache(maxsize=1)
def _data() -> dict[str, Any]:
    content: dict[str, Any] = json.loads(DATA.read_text(encoding="utf-8"))
    return content


def resolve_tasks(words: Sequence[str]) -> tuple[str, ...]:
    """Return the task names of a list of words, each once, in order.

    Args:
        words: Names of tasks (`reach_target`, `ReachTarget`), files (`mine/slide_bolt.py`), sets (`FS10_V1`, `MT15_V1`, `tier1`),
            parts of sets (`FS10_V1:test`), and `all`.

    Raises:
        UnknownName: A word is neither a task nor a set; proposes the nearest name.
        TaskError: A file contains no task.
    """
    return tuple(dict.fromkeys(name for word in as_names(words, "words") for name in _named(word)))


def _named(word: str) -> Iterator[str]:
    """Yield the tasks of one word."""
    if word == ALL:
        yield from usable_task_names()
    elif word.partition(":")[0] in set_contents():
        yield from task_set(word).tasks
    elif word.endswith(".py") or "/" in word:
        find_task(word)
        yield word
    elif (name := snake_case(word)) in _known():
        yield name
    else:
        try:
            yield task_class(word).get_name()  # a task of another package
        except UnknownName as error:
            known = (*_known(), *task_names(), *set_contents(), ALL)
            raise UnknownName("task or set of tasks", word, known, _COMMAND) from error


def _known() -> tuple[str, ...]:
    return (*public_tasks(), *variant_tasks(), *gembench_tasks())
