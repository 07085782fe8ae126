"""Tasks of stored demonstrations: the class that replays them, and the task files in a dataset.

A dataset contains copies of the files of tasks that are not in the library (`datasets.task_copy`). They can come from an
untrusted source, so they are executed only with permission of the user. Files that the user passes, and installed tasks, need
no permission.
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
    """Copy the files of a task to a dataset, so that others can replay its demonstrations; not for tasks of the library.

    Raises:
        DatasetConflict: It contains episodes of another task with this name, or of this task before its files changed.
        StorageError: The disk cannot be written to.
    """
    name = checked_class(task).get_name()
    kept = kept_task(root, name)
    if is_of_library(task):
        if kept is not None:
            raise DatasetConflict(
                f"'{root}' contains episodes of another task '{name}', of '{kept.path}' and not of the library. "
                "Choose another folder."
            )
        return
    if kept is None and name in library_names() and has_manifest(root, name):
        raise DatasetConflict(
            f"'{root}' contains episodes of the library task '{name}'. Choose another folder, or rename your task."
        )
    files = task_files(task)
    keep_files(root, name, task.scene_file().with_suffix(".py").name, {n: file.read_bytes() for n, file in files.items()})


def keep_tasks(root: Path, tasks: Iterable[type[Task]]) -> None:
    """Copy the files of several tasks; see `keep_task`."""
    for task in as_several(tasks, "tasks"):
        keep_task(root, task)


def stored_task(root: Path, name: str, own: OwnTasks | None = None, trust_task_files: bool = False) -> type[Task]:
    """Return the class of a task whose demonstrations are stored.

    A task file of the user takes precedence. If the dataset contains files of the task, the result is the installed task with
    the same files, or the copy in the dataset if it is trusted. Otherwise it is the task with this name.

    Args:
        root: Folder of the dataset.
        name: Task name.
        own: Task classes of the user, from `own_tasks`.
        trust_task_files: Allow the execution of code in the dataset.

    Raises:
        UntrustedTaskFile: The task is code in the dataset, and its execution is not allowed.
        EpisodeFileError: That code is damaged.
        UnknownName: There is no task with this name.
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
    """Return the tasks to record into a dataset: name or file of the user -> class.

    Files belong to the user. A name selects the task in the dataset, as in `stored_task`, or the installed task.

    Raises:
        TaskError: Two different tasks have one name.
        UnknownName: There is no task with this name.
        UntrustedTaskFile: A name refers to code in the dataset, and its execution is not allowed.
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
                f"Two different tasks have the name '{task.get_name()}'; the second is '{word}'. Record only one of them here."
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
