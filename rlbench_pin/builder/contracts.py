"""Records shared by the parts of the builder: the text of a task, and the results of the worker process."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from rlbench_pin.spatial import FloatArray
from rlbench_pin.viewer.recording import Failure, Problem

Standing = Literal["free", "collides", "unreachable"]
"""Of a waypoint: the gripper reaches it, reaches it but is in contact, does not reach it."""


@dataclass(frozen=True)
class TaskText:
    """The two files of a task as the editor shows them."""

    name: str
    """Name of the task."""
    folder: Path
    """Folder of the files; relative paths in the scene, such as `./cup.urdf`, start here."""
    scene: str
    """Content of `<task>.toml`."""
    python: str
    """Content of `<task>.py`."""


@dataclass(frozen=True)
class OpenedTask:
    """The content of a task that the worker process has built."""

    variations: int
    """Number of variations."""
    conditions: tuple[str, ...]
    """The success conditions as text, in order."""
    graspable: tuple[str, ...]
    """Names of the bodies that may be grasped."""
    waypoints: tuple[str, ...]
    """Names of the waypoints in the order of visits."""
    problems: tuple[Problem, ...] = ()
    """Why it could not be built; then the rest is empty."""


@dataclass(frozen=True, eq=False)
class WaypointVerdict:
    """Whether the gripper reaches a waypoint."""

    waypoint: str
    """Its name."""
    standing: Standing
    """Green, amber or red."""
    cause: str = ""
    """Why it is not reached, as text."""
    pose: FloatArray = field(default_factory=lambda: np.zeros(7))
    """Pose (7,) of the tip at the waypoint, in the world."""
    configuration: FloatArray | None = None
    """Joint positions (n,) of the arm there [rad]; None out of reach."""
    failure: Failure | None = None
    """Pairs in collision, nearest pose."""


@dataclass(frozen=True, eq=False)
class PlannedPath:
    """The path of the tip to one waypoint."""

    waypoint: str
    """Name of the waypoint."""
    points: FloatArray
    """Positions (m, 3) of the tip [m]; none when there is no path."""
    method: str = ""
    """Planning method."""
    cause: str = ""
    """Why there is no path."""


@dataclass(frozen=True)
class ValidationLine:
    """A line of the validator's panel."""

    name: str
    """Name of the check in `rlbench-pin check`."""
    passed: bool | None
    """None while it is being validated."""
    figure: str
    """The measured value."""
    failures: tuple[tuple[int, int, str], ...] = ()
    """Seed, variation and cause of each failure."""
    meaning: str = ""
    """Measured quantity, and when the line passes."""


@dataclass(frozen=True, eq=False)
class ReachSpot:
    """One layout of the reach map."""

    place: tuple[float, float, float]
    """x, y [m] and yaw [rad] of the task's root."""
    reached: tuple[bool, ...]
    """For each waypoint."""
    spots: tuple[tuple[float, float], ...]
    """x, y of each waypoint [m]."""
    free: bool
    """Whether the arm in its home configuration touches nothing."""
