"""Recipes: parts that a bar turns about their hinge: doors and hoods that are pulled open or shut."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from rlbench_pin.evaluation.baselines.classical.perception import KnownModel, locate
from rlbench_pin.evaluation.baselines.classical.recipes.parts import world_axis
from rlbench_pin.evaluation.baselines.classical.recipes.seen import everything
from rlbench_pin.evaluation.baselines.classical.skills import Hand, Moves, arc, placed, pull, sloping
from rlbench_pin.spatial import FloatArray


@dataclass(frozen=True)
class Bar:
    """A part on a hinge, with a bar parallel to that."""

    model: str
    """File of the model."""
    joint: str
    """Its hinge."""
    link: str
    """The part; its x-axis points from the bar to it."""
    middle: tuple[float, float, float]
    """Middle of the bar, in the frame of the part [m]."""
    begin: float
    """Angle that it stands at [rad]."""
    end: float
    """Angle that it is brought to [rad]."""


MICROWAVE = Bar("microwave/microwave", "door", "door_link", (-0.06, -0.255, 0.0), 0.0, 1.5)
FRIDGE = Bar("fridge/fridge", "upper_door", "upper_link", (-0.086, -0.312, -0.09), 0.0, 1.35)
HOOD_UP = Bar("hooded_grill/hooded_grill", "lid", "hood", (-0.334, 0.0, 0.042), 0.0, 1.0)
HOOD_DOWN = Bar("hooded_grill/hooded_grill", "lid", "hood", (-0.334, 0.0, 0.042), 1.2, 0.15)


def turn_bar(hand: Hand, bar: Bar) -> Moves:
    """Grip a bar, go about its hinge with it, let go and draw back; the hand turns less than the part."""
    state = {bar.joint: bar.begin}
    found = locate(KnownModel.named(bar.model), everything(hand), [state])
    axis, part = world_axis(found, bar.joint), found.placement * found.model.placement(bar.link, state)
    point = part.act(np.array(bar.middle))
    inwards = part.rotation[:, 0] * (1.0, 1.0, 0.0)
    angles = np.linspace(0.0, bar.end - bar.begin, 9)[1:]
    points = arc(axis, point, angles)
    ways = []
    for turn in _across(sloping(inwards / np.linalg.norm(inwards), (0.4, 0.8), (0.0, 0.4, -0.4)), axis.direction):
        for share in (0.1, 0.4):
            turned = [pin.exp3(share * angle * axis.direction) @ turn for angle in angles]
            held = [placed(t, p) for t, p in zip(turned, points, strict=True)]
            ways.append([placed(turn, point - 0.1 * turn[:, 2]), placed(turn, point), *held])
    yield from pull(hand, hand.choose(ways))
    yield from hand.grip(True)
    yield from hand.shift(-0.1 * hand.tip.rotation[:, 2])


def _across(turns: list[FloatArray], bar: FloatArray) -> list[FloatArray]:
    """Return the orientations whose fingers are on both sides of a bar along a direction (3,)."""
    return [turn for turn in turns if abs(turn[:, 1] @ bar) < 0.2]
