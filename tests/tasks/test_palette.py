"""The named colours."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.errors import TaskError
from rlbench_pin.tasks import BUTTON_COLORS, COLORS, distractor_colors, fill_up_colors


def test_there_are_twenty_different_colours_in_the_known_order() -> None:
    """The place of a colour is its variation."""
    names = (
        "red maroon lime green blue navy yellow cyan magenta silver gray orange olive purple teal azure violet rose black white"
    )
    assert [color.name for color in COLORS] == names.split()
    assert len({color.rgb for color in COLORS}) == 20


def test_buttons_leave_out_the_two_colours_of_their_caps() -> None:
    """Same order without red and lime."""
    assert [c.name for c in BUTTON_COLORS] == [c.name for c in COLORS if c.name not in ("red", "lime")]
    assert len(BUTTON_COLORS) == 18


def test_distractors_differ_from_the_goal_and_from_each_other() -> None:
    """Every other colour can be drawn, the goal never."""
    rng = np.random.default_rng(0)
    seen = set()
    for _ in range(200):
        colors = distractor_colors(rng, 4, 3)
        assert len(set(colors)) == 3
        seen |= set(colors)
    assert seen == set(COLORS) - {COLORS[4]}
    assert len(distractor_colors(rng, 0, 19)) == 19


def test_an_unknown_goal_is_refused() -> None:
    """The palette says how far it goes."""
    with pytest.raises(TaskError, match="0 to 19"):
        distractor_colors(np.random.default_rng(0), 20, 1)


def test_asked_colours_are_filled_up_from_the_rest_of_a_palette() -> None:
    """The asked ones come first; the same draws give the same colours."""
    asked = (BUTTON_COLORS[3], BUTTON_COLORS[1])
    colors = fill_up_colors(np.random.default_rng(0), asked, 5, BUTTON_COLORS)
    assert colors[:2] == list(asked)
    assert len(set(colors)) == 5
    assert set(colors) <= set(BUTTON_COLORS)
    assert colors == fill_up_colors(np.random.default_rng(0), asked, 5, BUTTON_COLORS)
    assert fill_up_colors(np.random.default_rng(0), asked, 2, BUTTON_COLORS) == list(asked)
