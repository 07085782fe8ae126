"""Lamps that are switched on and off, jars that are opened and closed."""

from __future__ import annotations

import pytest

from tests.tasks.goals.goal import Goal, goal_of
from tests.tasks.running import begin, running

BULBS = {True: (1.0, 1.0, 1.0), False: (0.0, 0.0, 0.0)}
"""Whether a lamp shines -> colour of its bulb."""


def shines(goal: Goal) -> bool:
    """Whether the lamp is seen to shine: the bulb is white and the shade is bright, or both are dark."""
    lamp = goal.world.body("lamp")
    bulb, shade = (lamp.colors[lamp.model.link_index(link)][:3] for link in ("bulb", "shade"))
    (bright,) = (bright for bright, rgb in BULBS.items() if bulb == rgb)
    assert (sum(shade) > 2.0) if bright else (sum(shade) < 1.0)
    return bright


def check_switch(goal: Goal, at_first: bool) -> None:
    """Check that 3 mm change the light for the rest of the episode, and that the goal is the button down."""
    for depth in (0.0, 0.0029):
        goal.joint("button/cap_joint", depth)
        goal.tick()
        assert not goal.reached()
        assert shines(goal) is at_first
    goal.border(lambda depth: goal.joint("button/cap_joint", depth), inside=0.0031, outside=0.0029)
    goal.tick()
    assert goal.reached()
    assert shines(goal) is not at_first
    goal.joint("button/cap_joint", 0.0)
    goal.tick()
    assert not goal.reached()
    assert shines(goal) is not at_first
    begin(goal.task)
    assert shines(goal) is at_first


@goal_of("lamp_on")
def test_a_dark_lamp_is_switched_on(goal: Goal) -> None:
    """It is dark until the button is pressed, shines from then on, and is dark in the next episode."""
    check_switch(goal, at_first=False)


@goal_of("lamp_off")
def test_a_lamp_that_shines_is_switched_off(goal: Goal) -> None:
    """It shines until the button is pressed, is dark from then on, and shines in the next episode."""
    check_switch(goal, at_first=True)


@pytest.mark.parametrize("name", ["lamp_on", "lamp_off"])
def test_the_button_of_the_lamp_springs_back(name: str) -> None:
    """A pressed cap comes up by itself."""
    with running(name) as task:
        begin(task)
        cap = task.world.joint("button/cap_joint")
        cap.set_position(0.006)
        for _ in range(10):
            task.world.step()
        assert cap.position < 0.001
