"""Plain records that the parts of the builder exchange: what is wrong where, and what the stage has seen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from rlbench_pin.scene.spec import BodySpec
from rlbench_pin.spatial import FloatArray

FileKind = Literal["scene", "task"]
"""`<task>.toml` or `<task>.py`."""
Standing = Literal["free", "collides", "unreachable"]
"""Of a waypoint: the hand gets there, gets there but touches something, does not get there."""


@dataclass(frozen=True)
class Problem:
    """Something that is wrong in one of the two files."""

    file: FileKind
    """Which file."""
    line: int | None
    """Line, from 1; None when it concerns the whole file."""
    message: str
    """What is wrong, what was possible, and the next step."""


@dataclass(frozen=True)
class TaskText:
    """The two files of a task as they stand in the editor."""

    name: str
    """Name of the task."""
    folder: Path
    """Where the files lie; `./thing.urdf` in the scene is meant from here."""
    scene: str
    """Content of `<task>.toml`."""
    python: str
    """Content of `<task>.py`."""


@dataclass(frozen=True)
class OpenedTask:
    """What the stage says of a task that it has built."""

    variations: int
    """How many there are."""
    conditions: tuple[str, ...]
    """The success conditions as text, in order."""
    graspable: tuple[str, ...]
    """Names of what may be grasped."""
    waypoints: tuple[str, ...]
    """Names of the waypoints in the order of visits."""
    problems: tuple[Problem, ...] = ()
    """Why it could not be built; then the rest is empty."""


@dataclass(frozen=True, eq=False)
class Frame:
    """The world at the end of one control tick."""

    time: float
    """Since the reset [s]."""
    poses: Mapping[str, FloatArray]
    """`<body>/<link>` -> pose (7,) of the link's URDF frame in the world, for each link of every body of the scene, also those
    that do not collide."""
    arm: FloatArray
    """Joint positions of the arm [rad], shape (n,)."""
    fingers: FloatArray
    """Joint positions of the fingers [m]."""
    velocities: FloatArray
    """Joint velocities of the arm [rad/s], shape (n,)."""
    torques: FloatArray
    """Joint torques of the arm [Nm], shape (n,)."""
    held: tuple[bool, ...]
    """Whether each success condition holds, in their order."""
    success: bool
    """Whether the goal is reached."""
    colors: Mapping[str, tuple[float, float, float, float]] = field(default_factory=dict)
    """`<body>/<link>` -> rgba in 0..1, of the links that were painted since their file was read."""


@dataclass(frozen=True, eq=False)
class Failure:
    """Why a demonstration or a waypoint failed."""

    cause: str
    """In words, with the next step."""
    waypoint: str = ""
    """On the way to which."""
    pairs: tuple[tuple[str, str], ...] = ()
    """What touches what: names of links."""
    nearest: FloatArray | None = None
    """The nearest pose (7,) that the tip reaches, where one is known."""
    problem: Problem | None = None
    """The line of the task's own code that raised it, where it did."""


@dataclass(frozen=True)
class Leg:
    """A part of a demonstration: the motion to one waypoint."""

    waypoint: str
    """Where it leads."""
    begins: int
    """Number of the frame at which it begins."""
    method: str
    """How it was planned."""


@dataclass(frozen=True, eq=False)
class Recording:
    """A demonstration or another stretch of simulation, frame by frame."""

    frames: tuple[Frame, ...]
    """One for each control tick, the reset first."""
    conditions: tuple[str, ...]
    """What `Frame.held` is about."""
    instruction: str = ""
    """The first sentence of the episode."""
    legs: tuple[Leg, ...] = ()
    """In order."""
    failure: Failure | None = None
    """None when the goal was reached."""
    added: tuple[BodySpec, ...] = ()
    """Bodies that were added to the world, each under its name in `Frame.poses`; where they are in a frame, they are there."""


@dataclass(frozen=True, eq=False)
class WaypointVerdict:
    """Whether the hand gets to a waypoint."""

    waypoint: str
    """Its name."""
    standing: Standing
    """Green, amber or red."""
    cause: str = ""
    """Why not, in words."""
    pose: FloatArray = field(default_factory=lambda: np.zeros(7))
    """Pose (7,) of the tip at the waypoint, in the world."""
    configuration: FloatArray | None = None
    """Joint positions (n,) of the arm there [rad]; None out of reach."""
    failure: Failure | None = None
    """Pairs in collision, nearest pose."""


@dataclass(frozen=True, eq=False)
class PlannedPath:
    """The way of the tip to one waypoint."""

    waypoint: str
    """Where it leads."""
    points: FloatArray
    """Positions (m, 3) of the tip [m]; none when there is no way."""
    method: str = ""
    """How it was planned."""
    cause: str = ""
    """Why there is no way."""


@dataclass(frozen=True)
class Judgement:
    """A line of the validator's panel."""

    name: str
    """What is asked, as `rlbench-pin check` calls it."""
    passed: bool | None
    """None while it is being looked at."""
    figure: str
    """What was measured."""
    failures: tuple[tuple[int, int, str], ...] = ()
    """Seed, variation and cause of each failure."""


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
    """Whether the arm at home touches nothing."""
