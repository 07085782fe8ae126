"""Small worlds of boxes, as snapshots, for tests of collision checks and planning."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from rlbench_pin.robot.description import robot_description
from rlbench_pin.scene.snapshot import BodySnapshot, WorldSnapshot
from rlbench_pin.spatial import TABLE_HEIGHT

HOME = np.array(robot_description("panda").home)
TABLE_TOP = TABLE_HEIGHT


class Boxes:
    """Writes box models into a folder and builds snapshots of them.

    Args:
        folder: Where the URDF files go.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def box(
        self,
        name: str,
        size: Sequence[float],
        position: Sequence[float],
        *,
        fixed: bool = False,
        collides: bool = True,
        in_room: bool = False,
    ) -> BodySnapshot:
        """Return a box of a size (3,) with its centre at a world position (3,) [m]."""
        file = self.folder / f"{'x'.join(str(s) for s in size)}.urdf"
        geometry = f'<geometry><box size="{size[0]} {size[1]} {size[2]}"/></geometry>'
        file.write_text(f'<robot name="box"><link name="base"><collision>{geometry}</collision></link></robot>')
        pose = np.array([[*position, 0.0, 0.0, 0.0, 1.0]])
        return BodySnapshot(name, file, ("base",), pose, collides=collides, fixed=fixed, in_room=in_room)

    def snapshot(
        self, *bodies: BodySnapshot, arm: np.ndarray = HOME, opening: float = 0.04, attached: tuple[str, ...] = ()
    ) -> WorldSnapshot:
        """Return a world with a table and bodies."""
        table = self.box("table", (1.6, 1.5, 0.04), (0.15, 0.0, TABLE_TOP - 0.02), fixed=True, in_room=True)
        return WorldSnapshot((table, *bodies), np.array(arm), np.full(2, opening), attached)

    def screen(self) -> BodySnapshot:
        """Return a wall across the table that the arm has to go around."""
        return self.box("screen", (0.4, 0.04, 0.4), (0.35, 0.0, TABLE_TOP + 0.2), fixed=True)

    def cubes(self, count: int, seed: int = 0) -> list[BodySnapshot]:
        """Return cubes of 5 cm on the table."""
        rng = np.random.default_rng(seed)
        places = rng.uniform([0.0, -0.45], [0.55, 0.45], size=(count, 2))
        return [self.box(f"cube{i}", (0.05, 0.05, 0.05), (x, y, TABLE_TOP + 0.025)) for i, (x, y) in enumerate(places)]
