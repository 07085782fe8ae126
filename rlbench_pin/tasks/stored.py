"""Tasks of stored demonstrations: which class they are made again with, and what a dataset keeps of it.

Of a task that is not in the library, a dataset keeps the files (`datasets.task_copy`). They came with the dataset, perhaps from a
stranger, so they are run only when the user says so. What the user names, or has installed, needs no such word.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from rlbench_pin.datasets import checked_task_name, has_manifest, keep_files, kept_task
from rlbench_pin.errors import DatasetConflict, TaskError, UntrustedTaskFile
from rlbench_pin.tasks.registry import (
    OwnTasks,
    checked_class,
    digests,
    find_task,
    is_of_library,
    library_names,
    load_task_file,
    task_class,
    task_files,
    task_names,
)
from rlbench_pin.tasks.task import Task, snake_case
from rlbench_pin.values import as_flag, as_names, as_record, as_several


def keep_task(root: Path, task: type[Task]) -> None:
    """Let a dataset keep the files of a task, so that its demonstrations can be made again elsewhere; none for the library's.

    Raises:
        DatasetConflict: It holds episodes of another task of that name, or of this one before its files changed.
        StorageError: The disk cannot be written to.
    """
    name = checked_class(task).get_name()
    kept = kept_task(root, name)
    if is_of_library(task):
        if kept is not None:
            raise DatasetConflict(
                f"'{root}' holds episodes of a task '{name}' that is not the library's but that of '{kept.path}'. "
                "Choose another folder."
            )
        return
    if kept is None and name in library_names() and has_manifest(root, name):
        raise DatasetConflict(f"'{root}' holds episodes of the library's task '{name}'. Choose another folder, or rename yours.")
    files = task_files(task)
    keep_files(root, name, task.scene_file().with_suffix(".py").name, {n: file.read_bytes() for n, file in files.items()})


def keep_tasks(root: Path, tasks: Iterable[type[Task]]) -> None:
    """Keep the files of several tasks; see `keep_task`."""
    for task in as_several(tasks, "tasks"):
        keep_task(root, task)


def stored_task(root: Path, name: str, own: OwnTasks | None = None, trust_task_files: bool = False) -> type[Task]:
    """Return the class of a task whose demonstrations are stored.

    That is the one the user named a file of; else, where the dataset keeps the files of the task, the installed one with the
    same files, or the kept one when it is trusted; else the one of that name.

    Args:
        root: Folder of the dataset.
        name: Task name.
        own: What the user named, as from `own_tasks`.
        trust_task_files: Whether code that the dataset keeps may be run.

    Raises:
        UntrustedTaskFile: The task is code that came with the dataset, and nobody said that it may be run.
        EpisodeFileError: That code is damaged.
        UnknownName: No task is called so.
    """
    as_flag(trust_task_files, "trust_task_files")
    checked_task_name(name)
    if own is not None and name in as_record(own, Mapping, "own"):  # type: ignore[type-abstract]
        return own[name]
    kept = kept_task(root, name)
    if kept is None:
        return task_class(name)
    installed = task_class(name) if name in task_names() else None
    if installed is not None and digests(task_files(installed)) == kept.files:
        return installed
    if not trust_task_files:
        raise UntrustedTaskFile(name, kept.path, "" if installed is None else _installed_differs(installed))
    kept.contents()
    return load_task_file(kept.path)


def chosen_tasks_of(root: Path, words: Iterable[str], trust_task_files: bool = False) -> dict[str, type[Task]]:
    """Return the tasks that are to be recorded into a dataset: as the user wrote them -> class.

    Files are the user's own. A name means what the dataset keeps of it, as in `stored_task`, or the installed task.

    Raises:
        TaskError: Two different tasks have one name.
        UnknownName: No task is called so.
        UntrustedTaskFile: A name refers to code that came with the dataset, and the caller has not allowed to run it.
    """
    trust_task_files = as_flag(trust_task_files, "trust_task_files")
    chosen: dict[str, type[Task]] = {}
    for word in as_names(as_several(words, "tasks"), "tasks"):
        name = snake_case(word)
        task = stored_task(root, name, None, trust_task_files) if _is_kept(root, name) else find_task(word)
        same = [known for known in chosen.values() if known.get_name() == task.get_name()]
        if not same:
            chosen[word] = task
        elif same[0] is not task:
            raise TaskError(
                f"Two different tasks are called '{task.get_name()}'; the second is '{word}'. Record one of them here."
            )
    return chosen


def _is_kept(root: Path, name: str) -> bool:
    return name.isidentifier() and kept_task(root, name) is not None


def _installed_differs(installed: type[Task]) -> str:
    return f" The installed task of that name ('{installed.scene_file().with_suffix('.py')}') is not the same."


__all__ = [
    "chosen_tasks_of",
    "keep_task",
    "keep_tasks",
    "stored_task",
]
