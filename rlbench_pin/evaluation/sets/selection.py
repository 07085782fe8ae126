"""Which tasks some words stand for: names, files and sets, mixed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from rlbench_pin.errors import MissingTasks, UnknownName
from rlbench_pin.evaluation.sets.catalogue import public_tasks, set_contents, task_set, variant_tasks
from rlbench_pin.tasks import find_task, task_class, task_names, usable_task_names
from rlbench_pin.tasks.task import snake_case
from rlbench_pin.values import as_flag, as_names

ALL = "all"
"""Stands for all tasks that are built."""
_COMMAND = "rlbench-pin list [--sets]"


@dataclass(frozen=True)
class TaskSelection:
    """Tasks that were asked for."""

    asked: str
    """The words, with blanks between them."""
    tasks: tuple[str, ...]
    """Names of those that are built, and files, each once, in order."""
    missing: tuple[str, ...]
    """Names of those that are not."""


def resolve_tasks(words: Sequence[str], available_only: bool = False) -> tuple[str, ...]:
    """Return the tasks that words stand for, each once, in order.

    Args:
        words: Names of tasks (`reach_target`, `ReachTarget`), files (`mine/slide_bolt.py`), sets (`FS10_V1`, `MT15_V1`, `tier1`),
            parts of sets (`FS10_V1:test`), and `all`.
        available_only: Leave out those that are known by name but not built yet.

    Raises:
        MissingTasks: Some are not built yet, and they are not to be left out, or nothing would be left.
        UnknownName: A word is neither a task nor a set; proposes the nearest name.
        TaskError: A file holds no task.
    """
    available_only, selection = as_flag(available_only, "available_only"), select_tasks(words)
    if selection.missing and not (available_only and selection.tasks):
        raise MissingTasks(selection.asked, selection.missing, selection.tasks)
    return selection.tasks


def select_tasks(words: Sequence[str]) -> TaskSelection:
    """Return the tasks that words stand for, those that are not built yet apart from the others.

    Raises:
        UnknownName: A word is neither a task nor a set; proposes the nearest name.
        TaskError: A file holds no task.
    """
    asked = as_names(words, "words")
    built = set(task_names())
    found = tuple(dict.fromkeys(name for word in asked for name in _named(word)))
    missing = tuple(name for name in found if name in _known() and name not in built)
    return TaskSelection(" ".join(asked), tuple(name for name in found if name not in missing), missing)


def _named(word: str) -> Iterator[str]:
    """Yield what one word stands for."""
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
        yield _built(word)


def _built(word: str) -> str:
    """Return the name of a task that is built, whether the public set knows it or not."""
    try:
        return task_class(word).get_name()
    except UnknownName as error:
        raise UnknownName("task or set of tasks", word, (*_known(), *task_names(), *set_contents(), ALL), _COMMAND) from error


def _known() -> tuple[str, ...]:
    return (*public_tasks(), *variant_tasks())
