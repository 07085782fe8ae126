"""Recipes: pick something up, and perhaps lay it down elsewhere."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rlbench_pin.evaluation.baselines.classical.errors import NothingFound
from rlbench_pin.evaluation.baselines.classical.instruction import Instruction
from rlbench_pin.evaluation.baselines.classical.perception import Cloud, KnownModel, clusters, locate, rectangle
from rlbench_pin.evaluation.baselines.classical.recipes.seen import at, bottom, colored, everything, things
from rlbench_pin.evaluation.baselines.classical.skills import (
    DOWN,
    Hand,
    Moves,
    all_down,
    both_ways,
    down,
    pick,
    place,
    placed,
    pointing,
    pull,
    touch,
)
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray

GRATE = 0.14
"""Height of the grate of the grill [m]."""
FINGERS = 0.035
"""How far the open fingers reach to each side [m]."""


def lift_block_to_ring(hand: Hand, asked: Instruction) -> Moves:
    """Hold the block of the colour where the ring floats."""
    seen = things(hand)
    floating = [thing for thing in seen if bottom(thing) > 0.1]
    if not floating:
        raise NothingFound("No floating ring is seen.")
    block = colored([thing for thing in seen if bottom(thing) < 0.03], asked.colors[0])
    middle, yaw, _ = rectangle(block.points)
    yield from pick(hand, at(middle, 0.0225), _across(yaw, middle, block, seen))
    yield from touch(hand, floating[0].middle, [hand.tip.rotation, *all_down(16)])


def lift_cup(hand: Hand, asked: Instruction) -> Moves:
    """Grip the cup of the colour at its rim, one finger inside, and raise it."""
    cups = things(hand)
    cup = colored(cups, asked.colors[0])
    rest = np.concatenate([other.points for other in cups if other is not cup] or [np.full((1, 3), 9.0)])
    rim = cup.points[cup.points[:, 2] > cup.points[:, 2].max() - 0.006]
    middle = 0.5 * (rim[:, :2].min(axis=0) + rim[:, :2].max(axis=0))
    radius = float(np.percentile(np.linalg.norm(rim[:, :2] - middle, axis=1), 90)) - 0.002
    yaws = np.linspace(-np.pi, np.pi, 12, endpoint=False)
    places = [middle + radius * np.array([np.cos(yaw), np.sin(yaw)]) for yaw in yaws]
    best = int(np.argmax([np.linalg.norm(rest[:, :2] - place, axis=1).min() for place in places]))
    point = at(places[best], float(cup.points[:, 2].max() - TABLE_HEIGHT) - 0.012)
    yield from pick(hand, point, both_ways([down(float(yaws[best]))]), lift=0.2)


def lift_lid(hand: Hand, asked: Instruction) -> Moves:
    """Take the lid of the pan by its knob, its highest part, and hold it above."""
    pan = everything(hand)
    top = pan.points[:, 2].max()
    knob = pan.where(pan.points[:, 2] > top - 0.01)
    point = np.array([*knob.middle[:2], top - 0.012])
    yield from pick(hand, point, all_down(), lift=0.14)


def bin_paper(hand: Hand, asked: Instruction) -> Moves:
    """Pick the ball of paper, the palest of the small things, and let it fall into the bin."""
    seen = things(hand)
    bin_, small = seen[0], [thing for thing in seen[1:] if thing.size[2] < 0.08]
    paper = colored(small, "white")
    middle = paper.middle[:2]
    turns = _across(0.0, middle, paper, seen, count=12)
    yield from pick(hand, at(middle, 0.023), turns, lift=0.25)
    yield from touch(hand, at(bin_.middle[:2], 0.29), [hand.tip.rotation, *all_down(16)])
    yield from hand.grip(True)


def meat_off_grill(hand: Hand, asked: Instruction) -> Moves:
    """Take the piece of meat off the grate, and lay it on the table by a long side of the grill."""
    cloud = everything(hand)
    grill = locate(KnownModel.named("grill/grill"), cloud.between(0.0, 0.142))
    pieces = [piece for piece in clusters(cloud.between(0.147, 0.25), gap=0.01) if piece.size[:2].max() < 0.2]
    middle, yaw = _meat(pieces, asked, GRATE)
    turns = both_ways([down(yaw)]) + both_ways([down(yaw + s) for s in (-0.3, 0.3)])
    yield from pick(hand, at(middle, 0.155), turns)
    side = grill.placement.rotation[:, 1]
    places = [grill.placement.translation + sign * 0.28 * side for sign in (1.0, -1.0)]
    nearest = min(places, key=lambda p: float(np.linalg.norm(p[:2] - np.array([0.2, 0.0]))))
    yield from place(hand, at(nearest[:2], 0.025), over=0.15)


def meat_on_grill(hand: Hand, asked: Instruction) -> Moves:
    """Take the piece of meat from the table, and lay it in the middle of the grate."""
    seen = things(hand)
    grill = locate(KnownModel.named("grill/grill"), seen[0])
    middle, yaw = _meat([thing for thing in seen[1:] if thing.size[2] < 0.08], asked, 0.0)
    yield from pick(hand, at(middle, 0.015), both_ways([down(yaw + s) for s in (0.0, -0.3, 0.3)]), lift=0.22)
    yield from place(hand, at(grill.placement.translation[:2], GRATE + 0.018))


def unplug(hand: Hand, asked: Instruction) -> Moves:
    """Grip the charger, which is what stands out of the wall, and pull it straight out."""
    cloud = everything(hand)
    panel = locate(KnownModel.named("socket_panel/socket_panel"), cloud)
    local = (cloud.points - panel.placement.translation) @ panel.placement.rotation
    charger = local[(np.abs(local - (-0.06, 0.0, 0.15)) < (0.045, 0.05, 0.05)).all(axis=1)]
    if len(charger) < 20:
        raise NothingFound("No charger is seen at the wall.")
    middle = panel.point(0.5 * (charger.min(axis=0) + charger.max(axis=0)))
    out, across = -panel.placement.rotation[:, 0], panel.placement.rotation[:, 1]
    turns = both_ways([pointing(np.cos(s) * DOWN - np.sin(s) * out, across) for s in (0.0, 0.4, 0.8)])
    way = hand.choose([[placed(t, middle - 0.1 * t[:, 2]), placed(t, middle), placed(t, middle + 0.12 * out)] for t in turns])
    yield from pull(hand, way)


def _meat(pieces: Sequence[Cloud], asked: Instruction, ground: float) -> tuple[FloatArray, float]:
    """Return middle x, y (2,) and heading across of the piece of meat whose height over the ground [m] is that of the named."""
    word = asked.one_of(("chicken", "steak")) or "steak"
    if not pieces:
        raise NothingFound(f"No {word} is seen.")
    tall = float(np.ptp(KnownModel.named(f"{word}/{word}").points_at()[:, 2]))
    piece = min(pieces, key=lambda piece: abs(bottom(piece) + piece.size[2] - ground - tall))
    middle, yaw, sides = rectangle(piece.points)
    return middle, yaw if sides[0] < sides[1] else yaw + 0.5 * np.pi


def _across(yaw: float, middle: FloatArray, thing: Cloud, others: Sequence[Cloud], count: int = 2) -> list[FloatArray]:
    """Return downward orientations at a yaw [rad] and turned from it, those first whose fingers have most room."""
    rest = np.concatenate([o.points for o in others if o is not thing and bottom(o) < 0.1] or [np.full((1, 3), 9.0)])[:, :2]
    yaws = [yaw + k * np.pi / count for k in range(count)]
    room = []
    for y in yaws:
        reach = 0.06 * np.array([np.cos(y), np.sin(y)])
        room.append(min(float(np.linalg.norm(rest - (middle + s * reach), axis=1).min()) for s in (-1.0, 1.0)))
    free = [y for y, r in zip(yaws, room, strict=True) if r > FINGERS] or [yaws[int(np.argmax(room))]]
    return both_ways([down(y) for y in free])
