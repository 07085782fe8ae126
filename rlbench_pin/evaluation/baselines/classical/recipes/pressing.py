"""Recipes: reach, press buttons, flip a switch, shove a block."""

from __future__ import annotations

import numpy as np

from rlbench_pin.evaluation.baselines.classical.errors import NothingFound
from rlbench_pin.evaluation.baselines.classical.instruction import Instruction
from rlbench_pin.evaluation.baselines.classical.perception import Cloud, KnownModel, clusters, locate
from rlbench_pin.evaluation.baselines.classical.recipes.seen import at, bottom, colored, everything, parts_colored, things
from rlbench_pin.evaluation.baselines.classical.skills import (
    Hand,
    Moves,
    all_down,
    both_ways,
    placed,
    pointing,
    press,
    sloping,
    sweep,
    touch,
)
from rlbench_pin.evaluation.baselines.classical.skills.poses import DOWN
from rlbench_pin.spatial import FloatArray

PRESSED = 0.0455
"""Height of the tip when a cap is down: 6 mm below its top, 9.5 mm of fingers [m]."""
RED, GREEN = (1.0, 0.0, 0.0), (0.0, 0.7, 0.15)


def reach_ball(hand: Hand, asked: Instruction) -> Moves:
    """Bring the tip to the ball of the colour."""
    ball = colored([thing for thing in things(hand) if bottom(thing) > 0.02], asked.colors[0])
    yield from touch(hand, ball.middle, all_down())


def press_buttons(hand: Hand, asked: Instruction) -> Moves:
    """Press the caps of the bases of the colours, in their order."""
    buttons = [(middle, cloud) for cloud in things(hand) for middle in _caps(cloud)]
    bases = [_base(middle, cloud) for middle, cloud in buttons]
    for name in asked.colors:
        base = colored(bases, name)
        middle = next(m for (m, _), b in zip(buttons, bases, strict=True) if b is base)
        yield from press(hand, at(middle, PRESSED), all_down())


def press_lamp_button(hand: Hand, asked: Instruction) -> Moves:
    """Press the red cap of the button of a lamp."""
    caps = [middle for cloud in things(hand) for middle in _caps(cloud)]
    if not caps:
        raise NothingFound("No cap of a button is seen.")
    yield from press(hand, at(caps[0], PRESSED), all_down())


def flip_switch(hand: Hand, asked: Instruction) -> Moves:
    """Push the raised half of the rocker in, sloping down towards the wall."""
    states = [{"rocker_joint": -0.6}, {"rocker_joint": 0.6}]
    panel = locate(KnownModel.named("switch_panel/switch_panel"), everything(hand), states)
    inwards = panel.placement.rotation[:, 0]
    upper = panel.joints["rocker_joint"] < 0.0
    end = panel.point(np.array([-0.022, 0.0, 0.15 if upper else 0.11]))
    turns = [turn for turn in sloping(inwards, (1.27,)) if abs(turn[2, 1]) < 0.1]  # fingers side by side
    before = -0.06 * inwards
    yield from sweep(hand, [[placed(turn, end + before), placed(turn, end)] for turn in turns], 0.04 * -inwards)
    yield from hand.shift(before)


def shove_block(hand: Hand, asked: Instruction) -> Moves:
    """Shove the red block onto the green square; look again after each push."""
    view = hand.look()
    square = max(clusters(parts_colored(view.marks, GREEN, 0.4)), key=len, default=None)
    for _ in range(3):
        block = max(clusters(parts_colored(hand.look().things, RED)), key=len, default=None)
        if square is None or block is None:
            raise NothingFound("No red block or no green square is seen.")
        way = square.middle[:2] - block.middle[:2]
        length = float(np.linalg.norm(way))
        if length < 0.02:
            return
        yield from _shove(hand, block.middle[:2], way / length, length)


def _shove(hand: Hand, block: FloatArray, along: FloatArray, length: float) -> Moves:
    """Push a block of 6 cm at x, y (2,) straight along a direction (2,) over a length [m], and go up."""
    start, up = block - 0.075 * along, np.array([0.0, 0.0, 0.12])
    end = block + (length - 0.04) * along
    forward = np.array([*along, 0.0])
    turns = both_ways([pointing(DOWN, np.cross(forward, DOWN)), pointing(DOWN, forward)])
    yield from sweep(hand, [[placed(t, at(start, 0.03)), placed(t, at(end, 0.03))] for t in turns], up)
    yield from hand.shift(up)


def _caps(cloud: Cloud) -> list[FloatArray]:
    """Return the middles x, y (2,) of round red things as high as caps."""
    level = cloud.between(0.035, 0.05)
    return [
        part.middle[:2]
        for part in clusters(parts_colored(level, RED, least=0.65), gap=0.008, fewest=15)
        if part.size[:2].max() < 0.05
    ]


def _base(middle: FloatArray, cloud: Cloud) -> Cloud:
    """Return the points of a button of middle x, y (2,) that do not belong to its cap."""
    apart = np.linalg.norm(cloud.points[:, :2] - middle, axis=1)
    return cloud.where((apart > 0.024) & (apart < 0.045))
