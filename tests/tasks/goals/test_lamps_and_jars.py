"""Lamps that are switched on and off, jars that are opened and closed."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.tasks import COLORS
from tests.tasks.goals.goal import Goal, goal_of
from tests.tasks.running import begin, running

LAMP_COLORS = {True: ((1.0, 0.97, 0.88), (0.88, 0.71, 0.44)), False: ((0.80, 0.79, 0.76), (0.93, 0.85, 0.73))}
"""Whether a lamp shines -> colours of its bulb and its shade."""


def shines(goal: Goal) -> bool:
    """Whether the lamp is seen to shine: bulb and shade have the colours in which they glow, or both those of glass and cloth."""
    lamp = goal.world.body("lamp")
    seen = tuple(lamp.colors[lamp.model.link_index(link)][:3] for link in ("bulb", "shade"))
    (bright,) = (bright for bright, colors in LAMP_COLORS.items() if seen == colors)
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


def jars_of(goal: Goal) -> tuple[str, str]:
    """Return the jar that shows the colour of the instructions, and the other one; both are coloured apart."""
    rgb = COLORS[goal.asked([color.name for color in COLORS])].rgb
    seen = {}
    for name in ("jar0", "jar1"):
        jar = goal.world.body(name)
        seen[jar.colors[jar.model.link_index("jar")][:3]] = name
    (other,) = set(seen.values()) - {seen[rgb]}
    return seen[rgb], other


@goal_of("open_jar", 0, 9, 19)
def test_the_lid_of_the_asked_jar_has_to_lie_in_the_ring(goal: Goal) -> None:
    """Either face up, let go, its edge inside; above the ring, beside it or still on the jar it does not count, nor the other."""
    asked, other = (f"lid{jar[-1]}" for jar in jars_of(goal))
    goal.put(other, (0.0, 0.0, 0.011), on="spot")
    assert not goal.reached()
    goal.put(other, (0.0, 0.0, 0.046), on=f"jar{other[-1]}")
    goal.ends(asked, (0.0, 0.0, 0.011), on="spot", x=(-0.08, 0.08), y=(-0.08, 0.08), z=(0.029,))
    goal.needs_release_of(asked)
    goal.put(asked, (0.0, 0.0, 0.011), (np.pi, 0.0, 0.0), on="spot")
    assert goal.reached()
    goal.put(asked, (0.0, 0.0, 0.06), on=f"jar{asked[-1]}")
    assert not goal.reached()


@goal_of("close_jar", 0, 9, 19)
def test_the_lid_has_to_sit_on_the_neck_of_the_asked_jar(goal: Goal) -> None:
    """On the rim, around the neck on all sides, let go; raised, upside down or on the other jar it does not count."""
    asked, other = jars_of(goal)
    seat = (0.0, 0.0, 0.0455)
    goal.put("lid", seat, on=other)
    assert not goal.reached()
    goal.ends("lid", seat, on=asked, x=(-0.0045, 0.0045), y=(-0.0052, 0.0052), z=(0.0035,))
    goal.needs_release_of("lid")
    for tilt in (0.157, -0.157):
        goal.border(lambda angle: goal.put("lid", seat, (angle, 0.0, 0.0), on=asked), 0.95 * tilt, 1.05 * tilt)
    for yaw in np.linspace(0.1, 0.6, 6):
        goal.put("lid", seat, (0.0, 0.0, yaw), on=asked)
        assert goal.reached()
    for height in (0.06, 0.0605, 0.061):
        goal.put("lid", (0.0, 0.0, height), (np.pi, 0.0, 0.0), on=asked)
        assert goal.world.sensor("seat").detects("lid")
        assert not goal.reached()


@goal_of("close_jar")
def test_a_lid_that_was_dropped_counts_only_where_it_fell_over_the_neck(goal: Goal) -> None:
    """Coaxial it falls into place; dropped 4 mm off and tilted it rests askew, in the sensor on the mouth, and does not count."""
    asked, _ = jars_of(goal)
    for shift, tilt, falls in ((0.004, 0.3, False), (0.0, 0.0, True), (0.0, 0.3, True), (0.012, 0.0, False)):
        goal.put("lid", (shift, 0.0, 0.066), (0.0, tilt, 0.0), on=asked)
        goal.world.body("lid").set_velocity(np.zeros(6))
        for _ in range(60):
            goal.world.step()
        assert goal.reached() is falls
        if (shift, tilt) == (0.004, 0.3):
            assert goal.world.sensor("seat").detects("lid")
