"""What the hand can do: touch, press, pick, place, sweep a part about its joint."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import pinocchio as pin

from rlbench_pin.evaluation.baselines.classical.perception import Axis
from rlbench_pin.evaluation.baselines.classical.skills.hand import Hand, Moves, Way
from rlbench_pin.evaluation.baselines.classical.skills.poses import placed
from rlbench_pin.spatial import FloatArray

PULLING = 0.1
"""Speed of the tip that pulls at something [m/s]."""
ABOVE = 0.1
"""How far before a thing the hand stops first [m]."""


def touch(hand: Hand, point: FloatArray, turns: Sequence[FloatArray]) -> Moves:
    """Bring the tip to a point (3,), with the first of some orientations (3, 3) that the arm reaches."""
    yield from hand.go(hand.choose([[placed(turn, point)] for turn in turns]))


def press(hand: Hand, point: FloatArray, turns: Sequence[FloatArray], back: float = ABOVE) -> Moves:
    """Push the closed fingers to a point (3,) along the hand, and go back by `back` [m]."""
    way = hand.choose([approach(turn, point, back) for turn in turns])
    yield from hand.go(way, is_open=False)
    yield from hand.slide(way.targets[1:])
    yield from hand.slide(way.targets[:1])


def pull(hand: Hand, way: Way) -> Moves:
    """Go to the first placement of a way, close the fingers at the second, and take what they hold along the others, gently."""
    yield from hand.go(way, is_open=True)
    yield from hand.slide(way.targets[1:2])
    yield from hand.grip(False)
    yield from hand.slide(way.targets[2:], PULLING)


def pick(hand: Hand, point: FloatArray, turns: Sequence[FloatArray], lift: float = ABOVE, back: float = ABOVE) -> Moves:
    """Close the fingers about a point (3,), and lift what they hold straight up by `lift` [m]."""
    up = np.array([0.0, 0.0, lift])
    way = hand.choose([[*approach(turn, point, back), placed(turn, point + up)] for turn in turns])
    yield from hand.go(way, is_open=True)
    yield from hand.slide(way.targets[1:2])
    yield from hand.grip(False)
    yield from hand.slide(way.targets[2:])


def place(hand: Hand, point: FloatArray, over: float = ABOVE) -> Moves:
    """Bring what is held over a point (3,), lower it there, let go, and go up again by `over` [m]."""
    turn, up = hand.tip.rotation, np.array([0.0, 0.0, over])
    turns = [turn @ pin.rpy.rpyToMatrix(0.0, 0.0, yaw) for yaw in (0.0, np.pi, 0.5 * np.pi, -0.5 * np.pi)]
    way = hand.choose([[placed(t, point + up), placed(t, point)] for t in turns])
    yield from hand.go(way)
    yield from hand.slide(way.targets[1:])
    yield from hand.grip(True)
    yield from hand.slide(way.targets[:1])


def sweep(hand: Hand, paths: Sequence[Sequence[pin.SE3]], back: FloatArray, is_open: bool = False) -> Moves:
    """Move along the best of several paths.

    Args:
        hand: The hand.
        paths: Placements of the tip, one after the other; all of them do.
        back: From where the hand comes to the start of a path, as an offset (3,) [m].
        is_open: Whether the fingers are open.
    """
    way = hand.choose([[pin.SE3(path[0].rotation, path[0].translation + back), *path] for path in paths])
    yield from hand.go(way, is_open)
    yield from hand.slide(way.targets[1:])


def arc(axis: Axis, point: FloatArray, angles: Iterable[float]) -> list[FloatArray]:
    """Return a point (3,) turned about an axis by each angle [rad]."""
    offset = point - axis.origin
    return [axis.origin + pin.exp3(angle * axis.direction) @ offset for angle in angles]


def approach(turn: FloatArray, point: FloatArray, back: float) -> list[pin.SE3]:
    """Return two placements of a hand: `back` before a point (3,) along its z, and there [m]."""
    return [placed(turn, point - back * turn[:, 2]), placed(turn, point)]
