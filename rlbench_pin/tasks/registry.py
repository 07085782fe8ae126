"""Which tasks there are, by name or by file. A task is imported only when it is asked for."""

from __future__ import annotations

import importlib
from functools import lru_cache
from os import PathLike
from pathlib import Path

from rlbench_pin.errors import TaskError, UnknownName
from rlbench_pin.plugins import Plugins, PluginTask, installed_plugins
from rlbench_pin.scene.reader import read_scene
from rlbench_pin.scene.spec import SceneSpec
from rlbench_pin.tasks.task import Task, snake_case
from rlbench_pin.tasks.task_file import camel_case, checked_class, class_in, load_task_file
from rlbench_pin.values import as_text

LIBRARY = Path(__file__).parent / "library"
LIST_COMMAND = "rlbench-pin list"


@lru_cache(maxsize=1)
def library_names() -> tuple[str, ...]:
    """Return the names of the tasks of the library: files with a scene beside them."""
    return tuple(sorted(file.stem for file in LIBRARY.glob("*.py") if file.with_suffix(".toml").is_file()))


def task_names() -> tuple[str, ...]:
    """Return the names of all tasks: those of the library, then those that other packages bring, each in alphabetical order."""
    return (*library_names(), *_plugins().tasks)


def task_class(name: str) -> type[Task]:
    """Return the class of a task.

    Args:
        name: `reach_target` or `ReachTarget`, of the library or of a package that brings tasks.

    Raises:
        UnknownName: No task is called so; proposes the nearest name.
        TaskError: The package that brings it is broken, or two packages claim the name.
    """
    if not isinstance(name, str):
        raise UnknownName("task", name, task_names(), LIST_COMMAND)
    stem = snake_case(name)
    if stem in library_names():
        return class_in(importlib.import_module(f"rlbench_pin.tasks.library.{stem}"), camel_case(stem))
    plugins = _plugins()
    if stem in plugins.tasks:
        return _plugin_class(plugins.tasks[stem])
    if stem in plugins.faults:
        raise TaskError(plugins.faults[stem])
    raise UnknownName("task", name, task_names(), LIST_COMMAND)


def find_task(name: str | PathLike[str]) -> type[Task]:
    """Return the task of that name, or the one in a file: a path, or a text that ends with `.py` or has a folder in it.

    Raises:
        UnknownName: No task is called so.
        TaskError: The file does not exist, cannot be loaded, or holds no task class named after it.
    """
    if not isinstance(name, str | PathLike):
        raise UnknownName("task", name, task_names(), LIST_COMMAND)
    if isinstance(name, PathLike) or name.endswith(".py") or "/" in name:
        return load_task_file(name)
    return task_class(name)


def task_origin(name: str) -> str:
    """Return the package that brings a task, with its version; empty for those of the library."""
    task = _plugins().tasks.get(as_text(name, "name"))
    return task.origin if task else ""


def plugin_faults() -> dict[str, str]:
    """Load every task that other packages bring, and return those that cannot be used: name of the task or package -> why."""
    plugins = _plugins()
    faults = dict(plugins.faults)
    for name, task in plugins.tasks.items():
        try:
            _plugin_class(task)
        except TaskError as error:
            faults[name] = str(error)
    return faults


def usable_task_names() -> tuple[str, ...]:
    """Return the names of all tasks but those that broken packages bring; these are loaded for it."""
    faults = plugin_faults()
    return tuple(name for name in task_names() if name not in faults or not task_origin(name))


def task_scene(task: type[Task]) -> SceneSpec:
    """Return the scene of a task; read once, and again only when the file has changed.

    Raises:
        SceneFileError: The file is missing or wrong.
        AssetNotFound: Something that the scene needs does not exist.
    """
    checked_class(task)
    file = task.scene_file()
    return _read(file, file.stat().st_mtime_ns) if file.is_file() else read_scene(file)


@lru_cache(maxsize=256)
def _read(file: Path, changed: int) -> SceneSpec:
    return read_scene(file)


@lru_cache(maxsize=1)
def _plugins() -> Plugins:
    return installed_plugins(library_names())


def _plugin_class(task: PluginTask) -> type[Task]:
    """Load a task of another package.

    Raises:
        TaskError: Its module cannot be imported, or what it names is no such task.
    """
    start = f"The task '{task.name}' of '{task.origin}' ({task.value})"
    try:
        found = task.load()
    except Exception as error:  # whatever a foreign module raises
        raise TaskError(
            f"{start} cannot be loaded: {type(error).__name__}: {error}. Repair that package or uninstall it."
        ) from error
    if not (isinstance(found, type) and issubclass(found, Task)):
        raise TaskError(f"{start} is no class derived from `rlbench_pin.tasks.Task`. Repair that package or uninstall it.")
    if found.get_name() != task.name:
        raise TaskError(f"{start} calls itself '{found.get_name()}'. Let its entry point have the same name.")
    if not found.scene_file().is_file():
        raise TaskError(f"{start} has no scene: '{found.scene_file()}' does not exist. Does that package contain its TOML files?")
    return found


__all__ = [
    "LIBRARY",
    "LIST_COMMAND",
    "find_task",
    "library_names",
    "plugin_faults",
    "task_class",
    "task_names",
    "task_origin",
    "task_scene",
    "usable_task_names",
]
