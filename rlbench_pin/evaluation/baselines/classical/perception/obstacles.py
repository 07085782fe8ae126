"""A cloud as a world to plan in: boxes around what is seen, and the table."""

from __future__ import annotations

import numpy as np

from rlbench_pin.evaluation.baselines.classical.perception.cloud import Cloud
from rlbench_pin.scene.snapshot import NO_FILE, BodySnapshot, Shape, WorldSnapshot
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray

CELL = 0.025
"""Side of the cubes that space is divided into [m]."""
LONGEST = 4
"""So many cubes in a row make one box at most, so that what may be touched is no more than what is meant."""
FEWEST = 2
"""A cube with fewer points than this is taken for noise."""
TABLE = ((0.3, 0.0, TABLE_HEIGHT - 0.05), (1.6, 2.0, 0.1))
"""Middle and sides of the table [m]."""


def filled_boxes(points: FloatArray, side: float = CELL, fewest: int = FEWEST) -> FloatArray:
    """Return boxes that together are the cubes with points in them, lowest and highest corners (m, 2, 3) [m].

    Args:
        points: Points (n, 3) [m].
        side: Side of the cubes [m].
        fewest: Points that a cube must have.
    """
    cells, counts = np.unique(np.floor(points / side).astype(np.int64), axis=0, return_counts=True)
    cells = cells[counts >= fewest]
    boxes = np.stack([cells, cells + 1], axis=1)
    for axis in (2, 0, 1):
        boxes = _joined(boxes, axis)
    return side * boxes.astype(float)


def _joined(boxes: np.ndarray, axis: int) -> np.ndarray:
    """Join boxes (m, 2, 3) of one cross-section that follow each other along an axis, up to the next multiple of `LONGEST`."""
    others = [i for i in range(3) if i != axis]
    section = boxes[:, :, others].reshape(-1, 4)
    order = np.lexsort((boxes[:, 0, axis], *section.T))
    boxes, section = boxes[order], section[order]
    goes_on = (section[1:] == section[:-1]).all(axis=1) & (boxes[1:, 0, axis] == boxes[:-1, 1, axis])
    goes_on &= boxes[1:, 0, axis] % LONGEST != 0
    first, last = np.append(True, ~goes_on)[: len(boxes)], np.append(~goes_on, True)[: len(boxes)]
    joined = boxes[first].copy()
    joined[:, 1] = boxes[last][:, 1]
    return joined


def as_world(cloud: Cloud, q: FloatArray, fingers: FloatArray) -> WorldSnapshot:
    """Return the table and boxes around a cloud, each a body of its own, the arm at `q` (n,) [rad] and `fingers` (2,) [m]."""
    bodies = [_box("table", np.array(TABLE[0]), np.array(TABLE[1]), in_room=True)]
    for k, (low, high) in enumerate(filled_boxes(cloud.points)):
        bodies.append(_box(f"seen {k}", 0.5 * (low + high), high - low))
    return WorldSnapshot(tuple(bodies), q, fingers)


def near(world: WorldSnapshot, point: FloatArray, within: float) -> list[str]:
    """Return the names of the boxes of a world, but the table, that come nearer to a point (3,) than `within` [m]."""
    names = []
    for body in world.bodies:
        apart = np.abs(point - body.link_poses[0, :3]) - 0.5 * np.array(body.shapes[0].size)
        if not body.in_room and np.linalg.norm(np.maximum(apart, 0.0)) < within:
            names.append(body.name)
    return names


def _box(name: str, middle: FloatArray, sides: FloatArray, in_room: bool = False) -> BodySnapshot:
    pose = np.array([[*middle, 0.0, 0.0, 0.0, 1.0]])
    shape = Shape("box", tuple(float(side) for side in sides))
    return BodySnapshot(name, NO_FILE, ("base",), pose, fixed=True, shapes=(shape,), in_room=in_room)
