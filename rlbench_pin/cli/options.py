"""Types of command line arguments, their checks, the files that commands write, and the engine."""

from __future__ import annotations

import errno
import json
import os
import tempfile
from collections.abc import Callable, Iterable, Mapping
from dataclasses import field, make_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar, get_type_hints

import tyro

from rlbench_pin.errors import TaskEnvironmentError, storing
from rlbench_pin.observation import CAMERAS, PRODUCTS, Disturbance

if TYPE_CHECKING:
    from rlbench_pin.processes import Engine

TaskName = Annotated[str, tyro.conf.arg(metavar="TASK")]
"""A task."""
Viewed = Annotated[str, tyro.conf.arg(metavar="TASK|FOLDER")]
"""A task, or a dataset."""
TaskNames = Annotated[tuple[str, ...], tyro.conf.arg(metavar="TASK...")]
"""Any number of tasks."""
OnlyTasks = Annotated[tuple[str, ...], tyro.conf.arg(metavar="TASK...", help_behavior_hint="")]
"""Tasks that a command is limited to; all by default."""
AnyTasks = Annotated[tuple[str, ...], tyro.conf.arg(metavar="[TASK...]", help_behavior_hint="")]
"""Tasks as optional arguments."""
SomeTasks = Annotated[tuple[str, ...], tyro.conf.arg(metavar="TASK...", help_behavior_hint="(required)")]
"""Tasks as required arguments; the command reports missing ones."""
Disturbances = Annotated[
    tuple[Disturbance, ...], tyro.conf.arg(metavar="{push,slip,stop}...", help_behavior_hint="(default: none)")
]
"""Disturbances of recovery demonstrations."""
RobotName = Annotated[str, tyro.conf.arg(metavar="ARM")]
"""An arm."""
Device = Annotated[str, tyro.conf.arg(metavar="DEVICE")]
"""Device of torch."""
MaybePath = Annotated[Path | None, tyro.conf.arg(metavar="PATH")]
"""An optional file or folder."""
MaybeInt = Annotated[int | None, tyro.conf.arg(metavar="INT")]
"""An optional number."""
MaybeText = Annotated[str | None, tyro.conf.arg(metavar="TEXT")]
"""An optional text."""
MaybeBool = Annotated[bool | None, tyro.conf.arg(metavar="{True,False}")]
"""An optional choice."""
Files = Annotated[tuple[Path, ...], tyro.conf.arg(metavar="FILE...", help_behavior_hint="")]
"""Any number of files."""
SomeFiles = Annotated[tuple[Path, ...], tyro.conf.arg(metavar="FILE...", help_behavior_hint="(required)")]
"""One or more files."""
SomeFolders = Annotated[tuple[Path, ...], tyro.conf.arg(metavar="FOLDER...", help_behavior_hint="(required)")]
"""One or more folders."""
Cameras = Annotated[tuple[str, ...], tyro.conf.arg(metavar=f"{{{','.join(CAMERAS)}}}...")]
"""Any number of cameras."""
OnlyCameras = Annotated[tuple[str, ...], tyro.conf.arg(metavar=f"{{{','.join(CAMERAS)}}}...", help_behavior_hint="")]
"""Cameras that a command is limited to; all by default."""
Products = Annotated[tuple[str, ...], tyro.conf.arg(metavar=f"{{{','.join(PRODUCTS)}}}...")]
"""Any number of kinds of images."""
EngineName = Literal["processes", "ray"]
Compression = Literal["gzip", "lzf"]
RenderMode = Literal["opengl", "opengl3"]
ExportFormat = Literal["lerobot", "robomimic", "rlbench", "peract", "zarr"]
Size = Annotated[tuple[int, int], tyro.conf.arg(metavar="WIDTH HEIGHT")]
"""Width and height [px]."""


MaybeProtocol = Annotated[str | None, tyro.conf.arg(metavar="NAME|FILE", help_behavior_hint="")]
"""An optional protocol."""
CommandT = TypeVar("CommandT")


def with_defaults(command: type[CommandT], defaults: Mapping[str, Any]) -> type[CommandT]:
    """Return a command whose arguments have other defaults.

    Args:
        command: The command.
        defaults: Field -> default.
    """
    types = get_type_hints(command, include_extras=True)
    changed = [(name, types[name], field(default=value)) for name, value in defaults.items()]
    return make_dataclass(command.__name__, changed, bases=(command,), frozen=True)


def check_at_least(command: object, **least: int) -> None:
    """Check the lower bounds of numbers of a command, by the names of their fields; None is a number that was not given.

    Raises:
        TaskEnvironmentError: One of them, or a number of a pair, is below its bound.
    """
    for name, low in least.items():
        value = getattr(command, name)
        numbers = value if isinstance(value, tuple) else (value,)
        if any(number is not None and number < low for number in numbers):
            said = " ".join(map(str, numbers))
            raise TaskEnvironmentError(f"--{name.replace('_', '-')} is {said}; it must be at least {low}.")


def checked_names(words: Iterable[str], split: Callable[[Iterable[str]], tuple[str, ...]], usage: str) -> tuple[str, ...]:
    """Return the names in `words`; at least one is required.

    Args:
        words: The arguments of the command.
        split: Function that splits them.
        usage: Usage of the command, for the message.

    Raises:
        TaskEnvironmentError: There is none.
    """
    names = split(words)
    if not names:
        raise TaskEnvironmentError(f"No task was named. Use `{usage}`; `rlbench-pin list` prints the tasks.")
    return names


def write_whole(path: Path, content: bytes) -> Path:
    """Write a file atomically; see `datasets.storage.write_whole`."""
    from rlbench_pin.datasets import storage

    return storage.write_whole(path, content)


def check_folder(folder: Path) -> None:
    """Make a folder and check that files can be written there, before the work begins.

    Raises:
        StorageError: They cannot be written.
    """
    with storing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass


def check_file(path: Path) -> None:
    """Check that a file can be written, before the work begins; its folder is made.

    Raises:
        StorageError: It cannot be written.
    """
    with storing(path):
        if path.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        check_folder(path.parent)


def write_json(path: Path, content: object) -> None:
    """Write a JSON file.

    Raises:
        StorageError: It cannot be written.
    """
    write_whole(path, (json.dumps(content, indent=1) + "\n").encode())


def make_engine(name: EngineName, workers: int) -> Engine:
    """Return the engine of that name.

    Raises:
        MissingExtra: Ray is not installed.
    """
    from rlbench_pin import processes

    if name == "processes":
        return processes.ProcessEngine(workers) if workers else processes.SerialEngine()
    from rlbench_pin.processes.ray_engine import RayEngine

    return RayEngine(max(1, workers))
