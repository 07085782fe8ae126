"""Frames made by hand, and a drawing that records its calls."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

import numpy as np

from rlbench_pin.spatial import FloatArray, PoseLike
from rlbench_pin.viewer.figures import Figures
from rlbench_pin.viewer.recording import Frame, Recording, Segment

RED = (1.0, 0.0, 0.0, 1.0)


def frame(number: int, met: tuple[bool, ...] = (False,), bodies: tuple[str, ...] = ("cube",)) -> Frame:
    """Return frame `number` of an episode in which the arm turns its joints by 0.1 rad in each tick."""
    pose = np.array([0.01 * number, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])
    return Frame(
        time=0.05 * number,
        poses={f"{body}/base": pose for body in bodies},
        arm=np.full(7, 0.1 * number),
        fingers=np.array([0.04, 0.04]),
        velocities=np.full(7, 2.0),
        torques=np.linspace(0.0, 6.0, 7),
        conditions_met=met,
        success=all(met),
        colors={"cube/base": RED} if number > 5 else {},
    )


def recording(count: int = 10) -> Recording:
    """Return a recording whose one condition holds from frame 6 on."""
    frames = tuple(frame(i, (i >= 6,)) for i in range(count))
    return Recording(
        frames, ("cube inside goal",), "Put the cube there.", (Segment("waypoint0", 0, "straight"), Segment("waypoint1", 4, ""))
    )


class Notes(Figures):
    """Stands in for figures."""

    def __init__(self) -> None:
        self.moved: Mapping[str, FloatArray] = {}
        self.joints: FloatArray = np.zeros(0)
        self.colors: Mapping[str, tuple[float, float, float, float]] = {}
        self.bodies: frozenset[str] = frozenset()
        self.marked: tuple[str, ...] = ()
        self.ghost_poses: dict[str, PoseLike] = {}

    def move(self, poses: Mapping[str, FloatArray]) -> None:
        self.moved = poses

    def arm(self, q: FloatArray, fingers: FloatArray) -> None:
        self.joints = q

    def paint(self, colors: Mapping[str, tuple[float, float, float, float]]) -> None:
        self.colors = colors

    def present(self, bodies: Collection[str]) -> None:
        self.bodies = frozenset(bodies)

    def mark(self, names: Iterable[str], rgb: tuple[int, int, int] = (0, 0, 0)) -> None:
        self.marked = tuple(names)

    def ghost(self, name: str, pose: PoseLike, rgb: tuple[int, int, int]) -> None:
        self.ghost_poses[name] = pose

    def remove_ghost(self, name: str) -> None:
        self.ghost_poses.pop(name, None)
