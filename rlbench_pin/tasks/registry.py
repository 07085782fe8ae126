"""Which tasks there are, by name. A task is imported only when it is asked for."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import sys
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from types import ModuleType

from rlbench_pin.errors import TaskError, UnknownName
from rlbench_pin.scene.reader import read_scene
from rlbench_pin.scene.spec import SceneSpec
from rlbench_pin.tasks.task import Task, snake_case

LIBRARY = Path(__file__).parent / "library"
LIST_COMMAND = "rlbench-pin list"


@lru_cache(maxsize=1)
def task_names() -> tuple[str, ...]:
    """Return the names of all tasks of the library: files with a scene beside them."""
    return tuple(sorted(file.stem for file in LIBRARY.glob("*.py") if file.with_suffix(".toml").is_file()))


def task_class(name: str) -> type[Task]:
    """Return the class of a task.

    Args:
        name: `reach_target` or `ReachTarget`.

    Raises:
        UnknownName: No task is called so; proposes the nearest name.
    """
    stem = snake_case(name)
    if stem not in task_names():
        raise UnknownName("task", name, task_names(), LIST_COMMAND)
    return _class_in(importlib.import_module(f"rlbench_pin.tasks.library.{stem}"), camel_case(stem))


def task_scene(task: type[Task]) -> SceneSpec:
    """Return the scene of a task; read once, and again only when the file has changed.

    Raises:
        SceneFileError: The file is missing or wrong.
        AssetNotFound: Something that the scene needs does not exist.
    """
    file = task.scene_file()
    return _read(file, file.stat().st_mtime_ns) if file.is_file() else read_scene(file)


def load_task_file(path: Path | str) -> type[Task]:
    """Return the task class of a file outside the package, with its scene file beside it.

    Raises:
        TaskError: The file does not exist, or holds no task class named after it.
    """
    path = Path(path).resolve()
    if not path.is_file():
        raise TaskError(f"Task file '{path}' does not exist. `rlbench-pin new` makes one.")
    name = f"rlbench_pin_task_{path.stem}_{sha256(str(path).encode()).hexdigest()[:8]}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise TaskError(f"Task file '{path}' is not a Python file.")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return _class_in(module, camel_case(path.stem))


def find_task(name: str) -> type[Task]:
    """Return the task of that name, or the one in the file when `name` ends with `.py`.

    Raises:
        UnknownName: No task is called so.
        TaskError: The file does not exist, or holds no task class named after it.
    """
    return load_task_file(name) if name.endswith(".py") else task_class(name)


def camel_case(name: str) -> str:
    """Turn `reach_target` into `ReachTarget`."""
    return "".join(word.capitalize() for word in name.split("_"))


@lru_cache(maxsize=256)
def _read(file: Path, changed: int) -> SceneSpec:
    return read_scene(file)


def _class_in(module: ModuleType, name: str) -> type[Task]:
    found = getattr(module, name, None)
    if inspect.isclass(found) and issubclass(found, Task):
        return found
    raise TaskError(f"'{module.__file__}' holds no class '{name}' derived from Task. Name the class after its file.")
