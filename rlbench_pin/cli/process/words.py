"""Kinds of words on a command line as help shows them, and checks that a command is asked for something at all."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Annotated, Literal

import tyro

from rlbench_pin.errors import TaskEnvironmentError
from rlbench_pin.observation import CAMERAS, PRODUCTS

TaskName = Annotated[str, tyro.conf.arg(metavar="TASK")]
"""A task."""
Viewed = Annotated[str, tyro.conf.arg(metavar="TASK|FOLDER")]
"""A task, or a dataset."""
TaskNames = Annotated[tuple[str, ...], tyro.conf.arg(metavar="TASK...")]
"""Any number of tasks."""
OnlyTasks = Annotated[tuple[str, ...], tyro.conf.arg(metavar="TASK...", help_behavior_hint="")]
"""Tasks that a command keeps to; all when none is named."""
AnyTasks = Annotated[tuple[str, ...], tyro.conf.arg(metavar="[TASK...]", help_behavior_hint="")]
"""Tasks behind a command that can do without."""
SomeTasks = Annotated[tuple[str, ...], tyro.conf.arg(metavar="TASK...", help_behavior_hint="(required)")]
"""Tasks behind a command that cannot; it says so in its own words."""
RobotName = Annotated[str, tyro.conf.arg(metavar="ARM")]
"""An arm."""
Device = Annotated[str, tyro.conf.arg(metavar="DEVICE")]
"""Where torch computes."""
MaybePath = Annotated[Path | None, tyro.conf.arg(metavar="PATH")]
"""A file or folder that may be left out."""
MaybeInt = Annotated[int | None, tyro.conf.arg(metavar="INT")]
"""A number that may be left out."""
MaybeBool = Annotated[bool | None, tyro.conf.arg(metavar="{True,False}")]
"""A choice that may be left out."""
Files = Annotated[tuple[Path, ...], tyro.conf.arg(metavar="FILE...", help_behavior_hint="")]
"""Any number of files."""
SomeFiles = Annotated[tuple[Path, ...], tyro.conf.arg(metavar="FILE...", help_behavior_hint="(required)")]
"""Files, of which there must be one."""
SomeFolders = Annotated[tuple[Path, ...], tyro.conf.arg(metavar="FOLDER...", help_behavior_hint="(required)")]
"""Folders, of which there must be one."""
Cameras = Annotated[tuple[str, ...], tyro.conf.arg(metavar=f"{{{','.join(CAMERAS)}}}...")]
"""Any number of cameras."""
OnlyCameras = Annotated[tuple[str, ...], tyro.conf.arg(metavar=f"{{{','.join(CAMERAS)}}}...", help_behavior_hint="")]
"""Cameras that a command keeps to; all when none is named."""
Products = Annotated[tuple[str, ...], tyro.conf.arg(metavar=f"{{{','.join(PRODUCTS)}}}...")]
"""Any number of kinds of pictures."""
CONTROLLERS = (
    "TrajectoryTracker", "VelocityFollowing", "VelocityFollowing + SafetyFilter", "DifferentialIK, poses",
    "DifferentialIK, twists", "DifferentialIKQP, twists", "DifferentialIK, twists + SafetyFilter", "CartesianMPC",
    "CartesianMPC, distances", "ComputedTorque", "OperationalSpaceQP", "JointImpedance", "CartesianImpedance",
)  # fmt: skip
"""The controllers of `evaluate`, said here too so that help need not import them; a test compares these with those that work."""
Controllers = Annotated[tuple[str, ...], tyro.conf.arg(metavar=f"{{{'|'.join(CONTROLLERS)}}}...", help_behavior_hint="")]
"""Any number of controllers."""
EngineName = Literal["processes", "ray"]
Compression = Literal["gzip", "lzf"]
RenderMode = Literal["opengl", "opengl3"]
ExportFormat = Literal["lerobot", "robomimic", "rlbench", "peract", "zarr"]
Size = Annotated[tuple[int, int], tyro.conf.arg(metavar="WIDTH HEIGHT")]
"""Width and height [px]."""


def check_at_least(command: object, **least: int) -> None:
    """Check numbers of a command, each by the name of its field; one that is None was not given.

    Raises:
        TaskEnvironmentError: One of them, or a number of a pair, is lower than the least that makes sense.
    """
    for name, low in least.items():
        value = getattr(command, name)
        numbers = value if isinstance(value, tuple) else (value,)
        if any(number is not None and number < low for number in numbers):
            said = " ".join(map(str, numbers))
            raise TaskEnvironmentError(f"--{name.replace('_', '-')} is {said}; it must be at least {low}.")


def checked_names(words: Iterable[str], split: Callable[[Iterable[str]], tuple[str, ...]], usage: str) -> tuple[str, ...]:
    """Return the names in `words`, of which there must be one.

    Args:
        words: As they were typed.
        split: What takes them apart.
        usage: How the command is used.

    Raises:
        TaskEnvironmentError: There is none.
    """
    names = split(words)
    if not names:
        raise TaskEnvironmentError(f"No task was named. Use `{usage}`; `rlbench-pin list` prints the tasks.")
    return names
