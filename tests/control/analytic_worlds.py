"""Worlds without a simulator: boxes on a table, kinematic motion, and rigid-body dynamics by Pinocchio."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rlbench_pin.robot.distances import DistanceModel
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.snapshot import NO_FILE, BodySnapshot, Shape, WorldSnapshot
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray, pose_at

TABLE_TOP = TABLE_HEIGHT
TOP_DOWN = (0.0, 1.0, 0.0, 0.0)
"""Quaternion of a gripper that points down."""


def box(name: str, size: Sequence[float], position: Sequence[float], yaw: float = 0.0, in_room: bool = False) -> BodySnapshot:
    """Return a box of a size (3,) with its centre at a world position (3,) [m]."""
    shape = Shape("box", tuple(size))
    return BodySnapshot(name, NO_FILE, ("base",), pose_at(position, yaw=yaw)[None], fixed=True, shapes=(shape,), in_room=in_room)


def table() -> BodySnapshot:
    """Return the table."""
    return box("table", (1.6, 1.5, 0.04), (0.15, 0.0, TABLE_TOP - 0.02), in_room=True)


def cluttered(model: RobotModel, boxes: int = 10, seed: int = 0) -> WorldSnapshot:
    """Return the table with boxes of 10 cm in the arm's workspace, some of them in the air."""
    rng = np.random.default_rng(seed)
    places = rng.uniform([-0.05, -0.45, 0.05], [0.55, 0.45, 0.3], size=(boxes, 3)) + [0.0, 0.0, TABLE_TOP]
    bodies = [box(f"box{i}", (0.1, 0.1, 0.1), place, 0.4 * i) for i, place in enumerate(places)]
    return WorldSnapshot((table(), *bodies), model.home, np.full(2, 0.04))


def smallest_margin(distances: DistanceModel, q: FloatArray, world: float, own: float) -> float:
    """Return how far the nearest pair is above its minimum distance at `q` [m], measured afresh."""
    distances.visit(q)
    everything = np.arange(len(distances.bounds))
    return float((distances.probe(everything) - np.where(distances.crosses, world, own)).min())


def simulate(
    model: RobotModel, q: FloatArray, v: FloatArray, torque: FloatArray, dt: float, force: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return state after holding `torque` (n,) [N m], and a force (3,) [N] on the tip, for `dt` [s]; four steps inside."""
    step = dt / 4
    for _ in range(4):
        push = 0.0 if force is None else model.jacobian(q)[:3].T @ force
        v = v + step * model.forward_dynamics(q, v, torque + push)
        q = q + step * v
    return q, v


def random_goals(model: RobotModel, rng: np.random.Generator, count: int, spread: float = 0.5) -> list[FloatArray]:
    """Return tip poses that the arm reaches with joints within `spread` [rad] (one sigma) of home."""
    limits = model.limits
    joints = np.clip(model.home + spread * rng.normal(size=(count, model.size)), limits.lower + 0.1, limits.upper - 0.1)
    return [model.tip_pose(q) for q in joints]
