"""Lookup of task classes in the library, other packages and task files, and the files of a task."""

from __future__ import annotations

import importlib
import inspect
import re
import sys
from collections.abc import Iterable, Mapping
from functools import lru_cache
from hashlib import sha256
from keyword import iskeyword
from os import PathLike
from pathlib import Path
from types import ModuleType

from rlbench_pin.errors import AssetInvalid, AssetNotFound, InvalidValue, TaskError, UnknownName
from rlbench_pin.plugins import Plugins, PluginTask, installed_plugins
from rlbench_pin.scene.reader import read_scene, resolve_asset
from rlbench_pin.scene.spec import NAME_PATTERN, SceneSpec
from rlbench_pin.tasks.task import Task, snake_case
from rlbench_pin.urdf import read_urdf
from rlbench_pin.values import as_path, as_several, as_text

OwnTasks = Mapping[str, type[Task]]
"""Task name -> class from a task file of the user."""
_PREFIX = "rlbench_pin_task_"
"""Prefix of the module names of task files."""
_NAMED_IN_OBJ = re.compile(rb"^mtllib[ \t]+(\S+)", re.MULTILINE)
_NAMED_IN_MTL = re.compile(rb"^map_\w+[ \t]+(\S+)", re.MULTILINE)


def load_task_file(path: str | PathLike[str]) -> type[Task]:
    """Execute a task file outside the package and return its task class; unchanged files are executed once.

    The scene file must be in the same folder.

    Args:
        path: The Python file.

    Raises:
        TaskError: The file does not exist, cannot be executed, or contains no task class with the name of the file.
    """
    path = as_path(path, "path").resolve()
    if not path.is_file():
        near = path.with_name(f"{path.name}.py")
        advice = f"Did you mean '{near}'?" if near.is_file() else "`rlbench-pin new` creates one."
        raise TaskError(f"Task file '{path}' does not exist. {advice}")
    if path.suffix != ".py":
        raise TaskError(f"Task file '{path}' is not a Python file. Its name must end with `.py`.")
    try:
        content = path.read_bytes()
    except OSError as error:
        raise TaskError(f"Task file '{path}' cannot be read: {error.strerror}.") from error
    return _load(path, content)


def camel_case(name: str) -> str:
    """Convert `reach_target` to `ReachTarget`."""
    return "".join(word.capitalize() for word in as_text(name, "name").split("_"))


def name_fault(name: str) -> str:
    """Return why a new task cannot have this name, with the next step; "" if it can."""
    if not re.fullmatch(NAME_PATTERN, name):
        return "it is not a valid task name. Use lower-case letters, digits and underscores, starting with a letter."
    if iskeyword(name) or iskeyword(camel_case(name)):
        return "it is a keyword of Python. Choose another name."
    if camel_case(name) in sys.modules["rlbench_pin.tasks"].__all__:
        return f"its class would hide rlbench_pin.tasks.{camel_case(name)}, which task files import. Choose another name."
    return ""


def class_in(module: ModuleType, name: str) -> type[Task]:
    """Return the task class with a given name in a module.

    Raises:
        TaskError: There is no such class.
    """
    found = getattr(module, name, None)
    if isinstance(found, type) and issubclass(found, Task):
        return found
    raise TaskError(f"'{module.__file__}' contains no class '{name}' derived from Task. Name the class after its file.")


def checked_class(task: object) -> type[Task]:
    """Return a task class, or raise InvalidValue."""
    if not isinstance(task, type) or not issubclass(task, Task):
        raise InvalidValue("task", task, "has to be a task class", "Pass `find_task(name)`.")
    return task


def is_task_file(task: type[Task]) -> bool:
    """Return whether a task was loaded from a file by `load_task_file`."""
    return checked_class(task).__module__.startswith(_PREFIX)


def is_of_library(task: type[Task]) -> bool:
    """Return whether a task belongs to the library."""
    return task.__module__.startswith("rlbench_pin.tasks.library.")


def task_files(task: type[Task]) -> dict[str, Path]:
    """Return the files of a task: its Python file, its scene, and its own models and images in the scene.

    Returns:
        Path below the folder of the task file, with slashes -> file. Files outside that folder are omitted.

    Raises:
        SceneFileError: The scene file is missing or invalid.
    """
    scene = task.scene_file().resolve()
    folder = scene.parent
    files = [scene.with_suffix(".py"), scene]
    for body in read_scene(scene).body:
        for asset in (body.asset, *body.look_alikes):
            if asset.startswith(("./", "../")):
                files += _model_files(resolve_asset(scene, asset))
    inside = (file for file in files if file.is_relative_to(folder) and file.is_file())
    return {file.relative_to(folder).as_posix(): file for file in inside}


def digests(files: dict[str, Path]) -> dict[str, str]:
    """Return the SHA-256 of each file, with the same keys."""
    return {name: _digest(file.read_bytes()) for name, file in files.items()}


def own_tasks(files: Iterable[str | PathLike[str]]) -> dict[str, type[Task]]:
    """Load the task files of the user, and return their classes by task name.

    Raises:
        TaskError: A file cannot be loaded, or two tasks have the same name.
    """
    found: dict[str, type[Task]] = {}
    for file in as_several(files, "files"):
        task = load_task_file(file)
        if found.setdefault(task.get_name(), task) is not task:
            raise TaskError(f"Two task files have the name '{task.get_name()}'; the second is '{file}'. Pass only one of them.")
    return found


def task_reference(task: type[Task]) -> str:
    """Return a reference to a task for other processes: its name, or the absolute path of its file."""
    return str(task.scene_file().with_suffix(".py").resolve()) if is_task_file(task) else task.get_name()


def task_digest(task: type[Task]) -> str:
    """Return a digest of all files of a task outside the library; empty for tasks of the library."""
    checked_class(task)
    return "" if is_of_library(task) else " ".join(f"{n}:{s}" for n, s in sorted(digests(task_files(task)).items()))


@lru_cache(maxsize=64)
def _load(path: Path, content: bytes) -> type[Task]:
    """Execute the content of a file. It is compiled here, because an import could use stale or foreign bytecode."""
    name = f"{_PREFIX}{path.stem}_{_digest(bytes(path) + content)[:12]}"
    module = ModuleType(name)
    module.__file__ = str(path)
    sys.modules[name] = module  # dataclasses and annotations look their module up
    try:
        exec(compile(content, str(path), "exec", dont_inherit=True), module.__dict__)
        return class_in(module, camel_case(snake_case(path.stem)))
    except BaseException as error:
        del sys.modules[name]
        if isinstance(error, TaskError) or not isinstance(error, Exception | SystemExit):
            raise
        raise TaskError(f"Task file '{path}' cannot be loaded: {type(error).__name__}: {error}.{_line(error, path)}") from error


def _line(error: BaseException, path: Path) -> str:
    """Return the line of the file in which an error was raised, as text."""
    found, trace = 0, error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == str(path):
            found = trace.tb_lineno
        trace = trace.tb_next
    return f" See its line {found}." if found else ""


def _model_files(urdf: Path) -> list[Path]:
    """Return a URDF file and its existing meshes and images."""
    try:
        read = read_urdf(urdf)
    except (AssetNotFound, AssetInvalid):
        return [urdf]
    files = [urdf, *read.meshes, *read.textures]
    materials = [material for mesh in read.meshes if mesh.suffix == ".obj" for material in _named(mesh, _NAMED_IN_OBJ)]
    files += materials
    files += [image for material in materials for image in _named(material, _NAMED_IN_MTL)]
    return [file.resolve() for file in files]


def _named(file: Path, pattern: re.Pattern[bytes]) -> list[Path]:
    if not file.is_file():
        return []
    return [file.parent / name.decode(errors="replace") for name in pattern.findall(file.read_bytes())]


def _digest(content: bytes) -> str:
    return sha256(content).hexdigest()


LIBRARY = Path(__file__).parent / "library"
LIST_COMMAND = "rlbench-pin list"


@lru_cache(maxsize=1)
def library_names() -> tuple[str, ...]:
    """Return the names of the tasks in the library, from its scene files."""
    return tuple(sorted(file.stem for file in LIBRARY.glob("*.toml")))


def task_names() -> tuple[str, ...]:
    """Return the names of all tasks: of the library, then of other packages, each in alphabetical order."""
    return (*library_names(), *_plugins().tasks)


def task_class(name: str) -> type[Task]:
    """Return the class of a task.

    Args:
        name: `reach_target` or `ReachTarget`, of the library or of another package.

    Raises:
        UnknownName: There is no task with this name; the message proposes the most similar one.
        TaskError: The package of the task is broken, or two packages have a task with this name.
    """
    if not isinstance(name, str):
        raise UnknownName("task", name, task_names(), LIST_COMMAND)
    stem = snake_case(name)
    if stem in library_names():
        return _library_class(stem)
    plugins = _plugins()
    if stem in plugins.tasks:
        return _plugin_class(plugins.tasks[stem])
    if stem in plugins.faults:
        raise TaskError(plugins.faults[stem])
    raise UnknownName("task", name, task_names(), LIST_COMMAND)


@lru_cache(maxsize=256)
def _library_class(stem: str) -> type[Task]:
    """Return a class of the library: from its Python file or, without one, of the base task in its scene."""
    scene = LIBRARY / f"{stem}.toml"
    if scene.with_suffix(".py").is_file():
        return class_in(importlib.import_module(f"rlbench_pin.tasks.library.{stem}"), camel_case(stem))
    name = read_scene(scene).base
    assert name is not None
    base = _library_class(name)
    content = {"__module__": base.__module__, "__doc__": base.__doc__, "scene_file": classmethod(lambda cls: scene)}
    return type(camel_case(stem), (base,), content)


def source_files(task: type[Task]) -> tuple[Path, ...]:
    """Return the Python files of a task and of the tasks that it extends, their scenes, its own scene and its base."""
    python = [Path(inspect.getfile(kind)) for kind in checked_class(task).__mro__ if kind is not Task and issubclass(kind, Task)]
    scenes = [*(file.with_suffix(".toml") for file in python), task.scene_file()]
    bases = [scene.with_name(f"{base}.toml") for scene in scenes if (base := read_scene(scene).base)]
    return tuple(dict.fromkeys((*python, *scenes, *bases)))


def find_task(name: str | PathLike[str]) -> type[Task]:
    """Return the class of a task by name or by file: a path, or a text that ends with `.py` or contains a folder.

    Raises:
        UnknownName: There is no task with this name.
        TaskError: The file does not exist, cannot be loaded, or contains no task class with the name of the file.
    """
    if not isinstance(name, str | PathLike):
        raise UnknownName("task", name, task_names(), LIST_COMMAND)
    if isinstance(name, PathLike) or name.endswith(".py") or "/" in name:
        return load_task_file(name)
    return task_class(name)


def task_origin(name: str) -> str:
    """Return the package of a task with its version; empty for tasks of the library."""
    task = _plugins().tasks.get(as_text(name, "name"))
    return task.origin if task else ""


def plugin_faults() -> dict[str, str]:
    """Load all tasks of other packages, and return those that cannot be used: name of the task or package -> reason."""
    plugins = _plugins()
    faults = dict(plugins.faults)
    for name, task in plugins.tasks.items():
        try:
            _plugin_class(task)
        except TaskError as error:
            faults[name] = str(error)
    return faults


def usable_task_names() -> tuple[str, ...]:
    """Return the names of all tasks except those of broken packages; this loads the tasks of other packages."""
    faults = plugin_faults()
    return tuple(name for name in task_names() if name not in faults or not task_origin(name))


def task_scene(task: type[Task]) -> SceneSpec:
    """Return the scene of a task; the file is read once, and again only after a change.

    Raises:
        SceneFileError: The file is missing or invalid.
        AssetNotFound: An asset of the scene does not exist.
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
        TaskError: Its module cannot be imported, or its entry point is not a task of this name.
    """
    start = f"The task '{task.name}' of '{task.origin}' ({task.value})"
    try:
        found = task.load()
    except Exception as error:  # whatever a foreign module raises
        raise TaskError(
            f"{start} cannot be loaded: {type(error).__name__}: {error}. Repair that package or uninstall it."
        ) from error
    if not (isinstance(found, type) and issubclass(found, Task)):
        raise TaskError(f"{start} is not a class derived from `rlbench_pin.tasks.Task`. Repair that package or uninstall it.")
    if found.get_name() != task.name:
        raise TaskError(f"{start} calls itself '{found.get_name()}'. Let its entry point have the same name.")
    if not found.scene_file().is_file():
        raise TaskError(f"{start} has no scene: '{found.scene_file()}' does not exist. Does that package contain its TOML files?")
    return found
