"""The named colours of variations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rlbench_pin.errors import TaskError
from rlbench_pin.values import as_record, as_several, as_whole

Rgb = tuple[float, float, float]


class Color(NamedTuple):
    """A colour with its name in instructions; unpacks to `name, rgb`."""

    name: str
    rgb: Rgb


COLORS: tuple[Color, ...] = (
    Color("red", (1.0, 0.0, 0.0)),
    Color("maroon", (0.5, 0.0, 0.0)),
    Color("lime", (0.0, 1.0, 0.0)),
    Color("green", (0.0, 0.5, 0.0)),
    Color("blue", (0.0, 0.0, 1.0)),
    Color("navy", (0.0, 0.0, 0.5)),
    Color("yellow", (1.0, 1.0, 0.0)),
    Color("cyan", (0.0, 1.0, 1.0)),
    Color("magenta", (1.0, 0.0, 1.0)),
    Color("silver", (0.75, 0.75, 0.75)),
    Color("gray", (0.5, 0.5, 0.5)),
    Color("orange", (1.0, 0.5, 0.0)),
    Color("olive", (0.5, 0.5, 0.0)),
    Color("purple", (0.5, 0.0, 0.5)),
    Color("teal", (0.0, 0.5, 0.5)),
    Color("azure", (0.0, 0.5, 1.0)),
    Color("violet", (0.5, 0.0, 1.0)),
    Color("rose", (1.0, 0.0, 0.5)),
    Color("black", (0.0, 0.0, 0.0)),
    Color("white", (1.0, 1.0, 1.0)),
)
"""The 20 colours; the index in the tuple is the variation."""

BUTTON_COLORS: tuple[Color, ...] = tuple(color for color in COLORS if color.name not in ("red", "lime"))
"""The 18 colours of button bases: all except those of a button cap before and after it is pressed."""


def distractor_colors(rng: np.random.Generator, goal: int, count: int) -> tuple[Color, ...]:
    """Draw `count` different colours except `COLORS[goal]`."""
    as_record(rng, np.random.Generator, "rng")
    goal, count = as_whole(goal, "goal"), as_whole(count, "count", least=0, most=len(COLORS) - 1)
    if not 0 <= goal < len(COLORS):
        raise TaskError(f"There is no colour {goal}. Choose 0 to {len(COLORS) - 1}.")
    others = [i for i in range(len(COLORS)) if i != goal]
    return tuple(COLORS[i] for i in rng.choice(others, size=count, replace=False))


def fill_up_colors(rng: np.random.Generator, asked: Sequence[Color], count: int, palette: Sequence[Color]) -> list[Color]:
    """Return `count` colours: the given ones, then different ones drawn from the other colours of a palette.

    Raises:
        InvalidValue: `count` is below the number of given colours, or above the number of available ones.
    """
    as_record(rng, np.random.Generator, "rng")
    asked, palette = (tuple(as_record(c, Color, "a colour") for c in as_several(x, "colours")) for x in (asked, palette))
    others = [color for color in palette if color not in asked]
    count = as_whole(count, "count", least=len(asked), most=len(asked) + len(others))
    return [*asked, *(others[i] for i in rng.choice(len(others), count - len(asked), replace=False))]
