"""Orientations of the hand: z out of it, y from finger to finger."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from rlbench_pin.spatial import FloatArray

PAD = 0.0095
"""How far the fingers reach beyond the tip frame [m]."""
DOWN = np.array([0.0, 0.0, -1.0])
"""Towards the table."""


def pointing(direction: FloatArray, across: FloatArray) -> FloatArray:
    """Return the rotation (3, 3) of a hand that points along `direction`, fingers apart along `across` as far as that goes."""
    z = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
    y = np.asarray(across, dtype=float) - (z @ across) * z
    y = y / np.linalg.norm(y)
    return np.stack([np.cross(y, z), y, z], axis=1)


def both_ways(turns: Sequence[FloatArray]) -> list[FloatArray]:
    """Return rotations, each also with the fingers swapped."""
    half = np.diag([-1.0, -1.0, 1.0])
    return [turn @ t for turn in turns for t in (np.eye(3), half)]


def down(yaw: float) -> FloatArray:
    """Return the rotation (3, 3) of a hand that points down with its fingers apart along a heading [rad]."""
    return pointing(DOWN, np.array([np.cos(yaw), np.sin(yaw), 0.0]))


def all_down(count: int = 8) -> list[FloatArray]:
    """Return rotations of a hand that points down, all around."""
    return [down(float(yaw)) for yaw in np.linspace(-np.pi, np.pi, count, endpoint=False)]


def sloping(direction: FloatArray, slopes: Sequence[float], turns: Sequence[float] = (0.0,)) -> list[FloatArray]:
    """Return rotations of a hand that points along a level direction, turned about the vertical and sloping down.

    Args:
        direction: Level direction (3,).
        slopes: How far down it points [rad].
        turns: How far it is turned aside [rad].
    """
    found = []
    for turn in turns:
        level = pin.rpy.rpyToMatrix(0.0, 0.0, turn) @ direction
        for slope in slopes:
            z = np.cos(slope) * level + np.sin(slope) * DOWN
            found += [pointing(z, across) for across in (np.cross(level, DOWN), np.cross(z, np.cross(level, DOWN)))]
    return both_ways(found)


def placed(turn: FloatArray, point: FloatArray) -> pin.SE3:
    """Return a hand of an orientation (3, 3) whose tip is at a point (3,) [m]."""
    return pin.SE3(np.asarray(turn), np.asarray(point, dtype=float))
