"""Gymnasium ids for tasks that are not in the library: `register_task("mine/sort_two_cubes.py")`."""

from __future__ import annotations

import re
from os import PathLike

import gymnasium

from rlbench_pin.errors import InvalidArgument, TaskEnvironmentError
from rlbench_pin.gym.ids import MODES, gym_id, register
from rlbench_pin.tasks import (
    Task,
    checked_class,
    find_task,
    is_task_file,
    task_names,
    task_origin,
    task_reference,
    task_scene,
    usable_task_names,
)


def register_task(task: type[Task] | str | PathLike[str], namespace: str = "rlbench_pin") -> tuple[str, ...]:
    """Register a task with gymnasium, and return its ids: `<namespace>/<task>-state-v0` and `<namespace>/<task>-vision-v0`.

    Version 2 of the task has `-v1` instead, and so on.

    Args:
        task: A class, the name of a task, or a task file.
        namespace: Text before the slash.

    Raises:
        TaskEnvironmentError: An id already belongs to another task.
        UnknownName: There is no task with this name.
        TaskError: The file cannot be loaded.
    """
    if not isinstance(namespace, str) or not re.fullmatch(r"[\w-]+", namespace):
        raise InvalidArgument("namespace", namespace, "has to consist of letters, digits, '_' and '-'")
    chosen = find_task(task) if isinstance(task, str | PathLike) else checked_class(task)
    by_name = is_task_file(chosen) or (chosen.get_name() in task_names() and find_task(chosen.get_name()) is chosen)
    found_by = task_reference(chosen) if by_name else chosen  # a text, where there is one: every process understands it
    ids = tuple(gym_id(chosen.get_name(), mode, task_scene(chosen).version, namespace) for mode in MODES)
    for name, mode in zip(ids, MODES, strict=True):
        settings = {"task": found_by, "observation_mode": mode}
        taken = gymnasium.registry.get(name)
        if taken is not None and taken.kwargs != settings:
            raise TaskEnvironmentError(
                f"The id '{name}' already belongs to another task ({taken.kwargs.get('task')}). Pass another `namespace`."
            )
        register(name, settings)
    return ids


def register_plugin_tasks() -> tuple[str, ...]:
    """Register the tasks of installed packages, and return their ids; broken tasks are omitted."""
    names = [name for name in usable_task_names() if task_origin(name)]
    return tuple(name for task in names for name in register_task(task))
