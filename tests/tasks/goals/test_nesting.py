"""Cups that nest and chairs that stack: all of them, upright, in the asked one, and let go."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS
from tests.tasks.goals.goal import Goal, goal_of

CUP, CHAIR = 0.028, 0.03
"""How much higher a cup or a chair comes to rest on the one below it [m]."""


def asked_color(goal: Goal, *variations: int) -> tuple[float, ...]:
    """Return the colour that the first instruction names."""
    return COLORS[variations[goal.asked([COLORS[i].name for i in variations])]].rgb


def painted(goal: Goal, *names: str) -> list[tuple[float, ...]]:
    """Return the colour that each of some bodies has got, on one of its links."""
    return [color[:3] for name in names for color in goal.world.body(name).colors.values()]


def stack(goal: Goal, names: list[str], pitch: float, on: str = "base") -> None:
    """Put objects above another, each as high as it rests on the one before."""
    for level, name in enumerate(names, start=1):
        goal.put(name, (0.0, 0.0, pitch * level), on=on)


@goal_of("stack_cups", 0, 9, 19)
def test_both_other_cups_nest_in_the_asked_one(goal: Goal) -> None:
    """In either order, let go; one alone, beside the base or in the wrong cup does not count."""
    asked = asked_color(goal, 0, 9, 19)
    base, *others = painted(goal, "base", "cup0", "cup1")
    assert base == asked and asked not in others
    stack(goal, ["cup0"], CUP)
    assert not goal.reached()
    stack(goal, ["cup1"], CUP, on="cup0")
    assert goal.reached()
    stack(goal, ["cup1", "cup0"], CUP)
    goal.needs_release_of("cup0")
    goal.put("cup0", (0.1, 0.0, 0.0), on="base")
    stack(goal, ["cup1"], CUP, on="cup0")
    assert not goal.reached()
    stack(goal, ["base", "cup1"], CUP, on="cup0")
    assert not goal.reached()


@goal_of("stack_cups")
def test_nested_cups_are_upright_and_down_in_the_base(goal: Goal) -> None:
    """Foot and mouth within 1.5 cm of the axis, and not above; not tilted by 10 degrees, and not upside down."""
    stack(goal, ["cup0", "cup1"], CUP)
    goal.ends("cup0", (0.0, 0.0, CUP), on="base", x=(-0.015, 0.015), y=(-0.015, 0.015), z=(-0.014, 0.036))
    goal.ends("cup1", (0.0, 0.0, 2 * CUP), on="base", x=(-0.015, 0.015), z=(-0.042, 0.008))
    for turn in ((1.0, 0.0), (0.0, -1.0)):
        goal.border(lambda a, t=turn: goal.put("cup1", (0.0, 0.0, 2 * CUP), (a * t[0], a * t[1], 0.7), on="base"), 0.165, 0.17)
    goal.put("cup1", (0.0, 0.0, 2 * CUP + 0.09), (np.pi, 0.0, 0.0), on="base")
    assert not goal.reached(), "upside down"
    goal.put("cup1", (0.0, 0.0, CUP), (np.pi / 2.0, 0.0, 0.0), on="base")
    assert not goal.reached(), "on its side"


@goal_of("stack_chairs", 0, 9, 19)
def test_both_other_chairs_are_stacked_on_the_asked_one(goal: Goal) -> None:
    """In either order, let go; one alone, beside the base or on the wrong chair does not count."""
    asked = asked_color(goal, 0, 9, 19)
    base, *others = painted(goal, "base", "chair0", "chair1")
    assert base == asked and len({asked, *others}) == 3
    stack(goal, ["chair0"], CHAIR)
    assert not goal.reached()
    stack(goal, ["chair0", "chair1"], CHAIR)
    assert goal.reached()
    stack(goal, ["chair1", "chair0"], CHAIR)
    goal.needs_release_of("chair0")
    goal.put("chair0", (0.15, 0.0, 0.0), on="base")
    stack(goal, ["chair1"], CHAIR, on="chair0")
    assert not goal.reached()
    stack(goal, ["base", "chair1"], CHAIR, on="chair0")
    assert not goal.reached()


@goal_of("stack_chairs")
def test_stacked_chairs_are_turned_like_the_lowest_one(goal: Goal) -> None:
    """Seats over that of the base and not above the stack; roll, pitch and yaw up to 0.25; not back to front or upside down."""
    stack(goal, ["chair0", "chair1"], CHAIR)
    goal.ends("chair0", (0.0, 0.0, CHAIR), on="base", x=(-0.025, 0.025), y=(-0.025, 0.025), z=(-0.005, 0.035))
    goal.ends("chair1", (0.0, 0.0, 2 * CHAIR), on="base", x=(-0.025, 0.025), y=(-0.025, 0.025), z=(-0.035, 0.005))

    def turn(angle: float, axis: np.ndarray) -> None:
        """Turn the upper chair about the middle of its seat."""
        middle = np.array([0.002, 0.0, 0.085])
        goal.put("chair1", middle + (0.0, 0.0, 2 * CHAIR), tuple(angle * axis), on="base")
        goal.put("chair1", -middle, on="chair1")

    for axis in np.eye(3):
        for side in (-1.0, 1.0):
            goal.border(lambda a, u=side * axis: turn(a, u), inside=0.249, outside=0.251)
        for half_turns in (0.5, 1.0):
            turn(half_turns * np.pi, axis)
            assert not goal.reached()
