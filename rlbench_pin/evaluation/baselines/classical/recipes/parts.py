"""Recipes: parts that turn or slide: drawers, doors, lids, seats."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rlbench_pin.evaluation.baselines.classical.instruction import Instruction
from rlbench_pin.evaluation.baselines.classical.perception import Axis, KnownModel, Located, locate
from rlbench_pin.evaluation.baselines.classical.recipes.seen import everything
from rlbench_pin.evaluation.baselines.classical.skills import (
    DOWN,
    PAD,
    Hand,
    Moves,
    all_down,
    arc,
    both_ways,
    placed,
    pointing,
    press,
    pull,
    sloping,
    sweep,
)
from rlbench_pin.spatial import FloatArray

LEVELS = ("bottom", "middle", "top")
CLEAR = 0.03
"""How far before a part the fingers start [m]."""


@dataclass(frozen=True)
class Door:
    """A part on an upright hinge that is pushed shut."""

    model: str
    """File of the model."""
    joint: str
    """Its hinge."""
    link: str
    """The part."""
    states: tuple[float, ...]
    """Angles that it may stand at [rad]."""
    grip: float
    """Where it is pushed, as a share of its width from the hinge."""


@dataclass(frozen=True)
class Lid:
    """A part on a level hinge that is folded down."""

    model: str
    """File of the model."""
    joint: str
    """Its hinge."""
    link: str
    """The part."""
    states: tuple[float, ...]
    """Angles that it may stand at [rad]."""
    press: float
    """Height of the tip over the hinge when it is pressed flat [m]."""
    reach: float
    """How far from the hinge it is pressed [m]."""


MICROWAVE = Door("microwave/microwave", "door", "door_link", (0.8, 1.2, 1.6), 0.75)
FRIDGE = Door("fridge/fridge", "upper_door", "upper_link", (0.6, 0.9, 1.3), 0.75)
LAPTOP = Lid("laptop/laptop", "screen_hinge", "screen", (1.5, 1.9), 0.014, 0.139)
TOILET = Lid("toilet/toilet", "seat_hinge", "seat", (1.5, 1.8), 0.016, 0.183)


def push_drawer(hand: Hand, asked: Instruction) -> Moves:
    """Push the drawer that is out back into the chest."""
    level = asked.one_of(LEVELS) or "middle"
    joint = f"drawer_{level}"
    chest = locate(KnownModel.named("chest/chest_with_stops"), everything(hand), [{joint: s} for s in (0.05, 0.1, 0.15)])
    axis, points = world_axis(chest, joint), chest.link_points(f"drawer_{level}_link")
    front, out = _outermost(points, axis.direction), chest.joints[joint]
    stations = [front + (CLEAR + PAD) * axis.direction, front + (PAD - out - 0.01) * axis.direction]
    turns = sloping(-axis.direction, (0.0, 0.3, 0.6, 0.9), (0.0, 0.785, -0.785))
    paths = [[placed(turn, p) for p in stations] for turn in turns]
    yield from sweep(hand, paths, 0.1 * axis.direction)
    yield from hand.shift(0.1 * axis.direction)


def pull_drawer(hand: Hand, asked: Instruction) -> Moves:
    """Grip the handle of a drawer, pull it far out, let go."""
    level = asked.one_of(LEVELS) or "middle"
    joint = f"drawer_{level}"
    chest = locate(KnownModel.named("chest/chest"), everything(hand), [{joint: s} for s in (0.0, 0.05, 0.1)])
    axis, points = world_axis(chest, joint), chest.link_points(f"drawer_{level}_link")
    bar = _outermost(points, axis.direction) - 0.006 * axis.direction
    far = bar + (0.19 - chest.joints[joint]) * axis.direction
    level_hands = sloping(-axis.direction, (0.0,), (0.0, 0.4, -0.4, 0.785, -0.785))  # from sloping ones the bar slips
    turns = [turn for turn in level_hands if abs(turn[2, 1]) > 0.9]
    ways = [[placed(t, bar - 0.1 * t[:, 2]), placed(t, bar), placed(t, far)] for t in turns]
    yield from pull(hand, hand.choose(ways))


def push_door(hand: Hand, door: Door) -> Moves:
    """Push an open door about its hinge until it is nearly shut."""
    found = locate(KnownModel.named(door.model), everything(hand), [{door.joint: s} for s in door.states])
    axis, points = world_axis(found, door.joint), found.link_points(door.link)
    angle = found.joints[door.joint]
    point, outwards = _on_leaf(points, axis, door.grip)
    start = point + (CLEAR + PAD) * outwards
    angles = -np.linspace(0.0, angle - 0.1, 5)
    stations = arc(axis, start - CLEAR * outwards, angles)
    pushing = -arc(Axis(np.zeros(3), axis.direction), outwards, [-0.5 * angle])[0]
    turns = sloping(pushing, (0.0, 0.5, 1.0, 1.57), (0.0, 0.4, -0.4, 0.785, -0.785))
    paths = [[placed(turn, p) for p in (start, *stations[1:])] for turn in turns]
    yield from sweep(hand, paths, 0.08 * outwards)
    yield from hand.shift(0.1 * outwards)


def fold_lid(hand: Hand, lid: Lid) -> Moves:
    """Tip a raised lid over from behind, and press it flat."""
    found = locate(KnownModel.named(lid.model), everything(hand), [{lid.joint: s} for s in lid.states])
    axis, points = world_axis(found, lid.joint), found.link_points(lid.link)
    angle = found.joints[lid.joint]
    point, outwards = _on_leaf(points, axis, 0.97)
    start = point + (CLEAR + PAD) * outwards
    stations = arc(axis, point + PAD * outwards, -np.linspace(0.0, angle - 0.35, 6))
    turns = both_ways([pointing(DOWN, axis.direction), pointing(DOWN, outwards - outwards[2] * np.array([0.0, 0.0, 1.0]))])
    up = np.array([0.0, 0.0, 0.1])
    yield from sweep(hand, [[placed(t, p) for p in (start, *stations)] for t in turns], up)
    yield from hand.shift(up)
    free = np.cross(axis.direction, np.array([0.0, 0.0, 1.0]))
    flat = axis.origin - lid.reach * free + np.array([0.0, 0.0, lid.press])
    yield from press(hand, flat, all_down())


def world_axis(found: Located, joint: str) -> Axis:
    """Return a joint of a located model in the world."""
    axis = found.model.axis(joint, found.joints)
    return Axis(found.point(axis.origin), found.placement.rotation @ axis.direction)


def _outermost(points: FloatArray, direction: FloatArray) -> FloatArray:
    """Return the middle (3,) of what of some points (n, 3) is farthest along a direction."""
    along = points @ direction
    last = points[along > along.max() - 0.004]
    middle = 0.5 * (last.min(axis=0) + last.max(axis=0))
    return middle + (along.max() - middle @ direction) * direction


def _on_leaf(points: FloatArray, axis: Axis, share: float) -> tuple[FloatArray, FloatArray]:
    """Return a point (3,) on the outside of a leaf, and the unit vector (3,) out of it, the way that it opens.

    Args:
        points: Surface of the leaf (n, 3) [m].
        axis: Its hinge; the angle grows when it opens.
        share: How far from the hinge, as a share of its width.
    """
    offset = points - axis.origin
    offset = offset - np.outer(offset @ axis.direction, axis.direction)
    mean = offset.mean(axis=0)
    along = mean / np.linalg.norm(mean)
    outwards = np.cross(axis.direction, along)
    width = float(np.percentile(offset @ along, 99))
    near = np.abs(offset @ along - share * width) < 0.012
    surface = float(np.percentile((offset @ outwards)[near], 95))
    heights = points @ axis.direction
    middle = 0.5 * (heights.min() + heights.max()) - axis.origin @ axis.direction
    return axis.origin + middle * axis.direction + share * width * along + surface * outwards, outwards
