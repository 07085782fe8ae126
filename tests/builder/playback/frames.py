"""Frames made by hand, and a drawing that takes note of what it is told."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

import numpy as np

from rlbench_pin.builder.contracts import Frame, Leg, Recording
from rlbench_pin.spatial import FloatArray, PoseLike

RED = (1.0, 0.0, 0.0, 1.0)


def frame(number: int, held: tuple[bool, ...] = (False,), bodies: tuple[str, ...] = ("cube",)) -> Frame:
    """Return frame `number` of an episode in which the arm turns its joints by 0.1 rad in each tick."""
    pose = np.array([0.01 * number, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])
    return Frame(
        time=0.05 * number,
        poses={f"{body}/base": pose for body in bodies},
        arm=np.full(7, 0.1 * number),
        fingers=np.array([0.04, 0.04]),
        velocities=np.full(7, 2.0),
        torques=np.linspace(0.0, 6.0, 7),
        held=held,
        success=all(held),
        colors={"cube/base": RED} if number > 5 else {},
    )


def recording(count: int = 10) -> Recording:
    """Return a recording whose one condition holds from frame 6 on."""
    frames = tuple(frame(i, (i >= 6,)) for i in range(count))
    return Recording(
        frames, ("cube inside goal",), "Put the cube there.", (Leg("waypoint0", 0, "straight"), Leg("waypoint1", 4, ""))
    )


class Notes:
    """Stands in for figures."""

    def __init__(self) -> None:
        self.moved: Mapping[str, FloatArray] = {}
        self.joints: FloatArray = np.zeros(0)
        self.colors: Mapping[str, tuple[float, float, float, float]] = {}
        self.bodies: frozenset[str] = frozenset()
        self.marked: tuple[str, ...] = ()
        self.ghosts: dict[str, PoseLike] = {}

    def move(self, poses: Mapping[str, FloatArray]) -> None:
        """Take note."""
        self.moved = poses

    def arm(self, q: FloatArray, fingers: FloatArray) -> None:
        """Take note."""
        self.joints = q

    def paint(self, colors: Mapping[str, tuple[float, float, float, float]]) -> None:
        """Take note."""
        self.colors = colors

    def present(self, bodies: Collection[str]) -> None:
        """Take note."""
        self.bodies = frozenset(bodies)

    def mark(self, names: Iterable[str], rgb: tuple[int, int, int] = (0, 0, 0)) -> None:
        """Take note."""
        self.marked = tuple(names)

    def ghost(self, name: str, pose: PoseLike, rgb: tuple[int, int, int]) -> None:
        """Take note."""
        self.ghosts[name] = pose

    def remove_ghost(self, name: str) -> None:
        """Take note."""
        self.ghosts.pop(name, None)
