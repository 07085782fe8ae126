"""Which of the things seen is meant."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rlbench_pin.evaluation.baselines.classical.errors import NothingFound
from rlbench_pin.evaluation.baselines.classical.perception import Cloud, clusters, lit_color
from rlbench_pin.evaluation.baselines.classical.skills import Hand
from rlbench_pin.evaluation.baselines.sight.colors import distances
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray


def things(hand: Hand) -> list[Cloud]:
    """Return what stands apart, the largest first."""
    found = clusters(hand.look().things)
    if not found:
        raise NothingFound("No thing is seen.")
    return found


def everything(hand: Hand) -> Cloud:
    """Return all that is not table and not arm."""
    cloud = hand.look().things
    if len(cloud) == 0:
        raise NothingFound("No thing is seen.")
    return cloud


def colored(candidates: Sequence[Cloud], name: str) -> Cloud:
    """Return the thing whose colour is nearest to a word."""
    if not candidates:
        raise NothingFound(f"No thing is seen that could be {name}.")
    return min(candidates, key=lambda cloud: float(distances(lit_color(cloud.colors), name)))


def parts_colored(cloud: Cloud, rgb: Sequence[float], within: float = 0.3, least: float = 0.4) -> Cloud:
    """Return the points whose hue is near to that of a colour (3,), and whose brightness is a share `least` of it."""
    wanted = np.array(rgb) / max(rgb)
    brightest = np.maximum(cloud.colors.max(axis=1), 1e-3)
    near = np.linalg.norm(cloud.colors / brightest[:, None] - wanted, axis=1) < within
    return cloud.where(near & (brightest > least * max(rgb)))


def bottom(cloud: Cloud) -> float:
    """Return the height of the lowest point over the table [m]."""
    return float(cloud.points[:, 2].min() - TABLE_HEIGHT)


def at(flat: FloatArray, up: float) -> FloatArray:
    """Return a point (3,) from its x, y (2,) and its height over the table [m]."""
    return np.array([flat[0], flat[1], TABLE_HEIGHT + up])
