"""Wine that is laid into a rack, and a table that is set."""

from __future__ import annotations

import numpy as np

from tests.tasks.goals.goal import Goal, goal_of

LAID, TURNED_ROUND = (0.0, np.pi / 2.0, 0.0), (0.0, -np.pi / 2.0, 0.0)
NOTCHES = {"left": 0.084, "middle": 0.0, "right": -0.084}


def refuse_wine(goal: Goal, y: float) -> None:
    """Check that a bottle near the notch at `y` that does not lie in it does not count."""
    refused = (
        ((0.0, y, 0.18), (0.0, 0.0, 0.0)),  # standing
        ((0.0, y, 0.44), (np.pi, 0.0, 0.0)),  # on its neck
        ((-0.095, y, 0.205), LAID),  # in the air
        ((-0.095, y, 0.16), (0.0, np.pi / 2.0 - 0.4, 0.0)),  # leaning, the neck up
        ((-0.095, y, 0.21), (0.0, np.pi / 2.0 + 0.3, 0.0)),  # the neck down
        ((0.0, y - 0.095, 0.2125), (-np.pi / 2.0, 0.0, 0.0)),  # across the ridges
        ((-0.095, y, 0.0325), LAID),
        ((-0.25, y, 0.188), LAID),  # half out
        ((-0.095, 0.25, 0.188), LAID),
        ((-0.095, 0.25, 0.0325), LAID),  # beside the rack
    )
    for place, rpy in refused:
        goal.put("bottle", place, rpy, on="rack")
        assert not goal.reached(), (place, rpy)


@goal_of("stack_wine")
def test_the_bottle_has_to_lie_in_a_notch(goal: Goal) -> None:
    """In any of the three, either way round, let go; standing, leaning, across the ridges or beside the rack is refused."""
    for y in NOTCHES.values():
        refuse_wine(goal, y)
        goal.ends("bottle", (-0.095, y, 0.188), LAID, on="rack", x=(-0.025, 0.035), z=(-0.01, 0.01))
        goal.needs_release_of("bottle")
        goal.put("bottle", (0.095, y, 0.188), TURNED_ROUND, on="rack")
        assert goal.reached()
    goal.ends("bottle", (-0.095, 0.084, 0.188), LAID, on="rack", y=(0.016,))


@goal_of("place_wine_at_rack_location", 0, 1, 2)
def test_the_bottle_has_to_lie_in_the_notch_that_is_asked_for(goal: Goal) -> None:
    """Let go; in another one, or not lying, it does not count."""
    asked = tuple(NOTCHES)[goal.asked(tuple(NOTCHES))]
    for name, y in NOTCHES.items():
        refuse_wine(goal, y)
        goal.put("bottle", (-0.095, y, 0.188), LAID, on="rack")
        assert goal.reached() is (name == asked)
    there = (-0.095, NOTCHES[asked], 0.188)
    goal.ends("bottle", there, LAID, on="rack", x=(-0.025, 0.035), y=(-0.015, 0.015), z=(-0.01, 0.01))
    goal.put("bottle", (-0.095, NOTCHES[asked] - 0.01, 0.188), (0.0, np.pi / 2.0, 0.3), on="rack")
    assert not goal.reached()  # aslant
    goal.ends("bottle", (0.095, NOTCHES[asked], 0.188), TURNED_ROUND, on="rack", x=(0.025, -0.035))
    goal.needs_release_of("bottle")


PLACES = {
    "plate": (0.0, 0.0, 0.0),
    "fork": (0.0, 0.118, 0.004),
    "knife": (0.0, -0.118, 0.004),
    "spoon": (0.0, -0.186, 0.004),
    "glass": (0.135, -0.1, 0.0),
}
CUTLERY = ("fork", "knife", "spoon")


def set_table(goal: Goal) -> None:
    """Put every piece at its place."""
    for name, place in PLACES.items():
        goal.put(name, place, on="setting")


@goal_of("set_the_table")
def test_every_piece_has_to_be_at_its_place(goal: Goal) -> None:
    """Let go; with one missing, held, or a bit too far it does not count."""
    starts = {name: goal.place_of(name) for name in PLACES}
    for name, place in PLACES.items():
        assert not goal.reached(), f"reached without the {name}"
        goal.put(name, place, on="setting")
    for name, start in starts.items():
        goal.needs_release_of(name)
        goal.world.body(name).set_pose(start)
        assert not goal.reached(), name
        goal.put(name, PLACES[name], on="setting")
    goal.ends("plate", PLACES["plate"], on="setting", x=(-0.04, 0.04), y=(-0.04, 0.04), z=(0.005,))
    goal.ends("glass", PLACES["glass"], on="setting", x=(-0.03, 0.03), y=(-0.03, 0.03), z=(0.005,))
    for name in CUTLERY:
        goal.ends(name, PLACES[name], on="setting", x=(-0.04, 0.04), y=(-0.015, 0.015), z=(0.005,))


@goal_of("set_the_table")
def test_every_piece_has_to_lie_the_right_way(goal: Goal) -> None:
    """Upside down, tilted, askew, the wrong way round, leaning or in the place of another it does not count."""
    refused = {
        "plate": (
            ((0.0, 0.0, 0.022), (np.pi, 0.0, 0.0)),
            ((0.0, 0.0, 0.09), (np.pi / 2.0, 0.0, 0.0)),
            ((0.0, 0.0, 0.01), (0.1, 0.0, 0.0)),
        ),
        "glass": (
            ((0.135, -0.1, 0.1), (np.pi, 0.0, 0.0)),
            ((0.135, -0.1, 0.03), (np.pi / 2.0, 0.0, 0.0)),
            ((0.135, -0.1, 0.0), (0.4, 0.0, 0.0)),
        ),
    } | {
        name: (
            (PLACES[name], (0.0, 0.0, np.pi)),
            (PLACES[name], (0.0, 0.0, 0.3)),
            ((*PLACES[name][:2], 0.08), (0.0, np.pi / 2.0, 0.0)),
            ((*PLACES[name][:2], 0.02), (0.0, 0.2, 0.0)),
            ((0.0, 0.0, 0.009), (0.0, 0.0, 0.0)),  # on the plate
        )
        for name in CUTLERY
    }
    set_table(goal)
    assert goal.reached()
    for name, poses in refused.items():
        for place, rpy in poses:
            goal.put(name, place, rpy, on="setting")
            assert not goal.reached(), (name, place, rpy)
        goal.put(name, PLACES[name], on="setting")
        assert goal.reached()
    for one, other in (("fork", "knife"), ("knife", "spoon"), ("fork", "spoon")):
        goal.put(one, PLACES[other], on="setting")
        goal.put(other, PLACES[one], on="setting")
        assert not goal.reached(), f"{one} and {other} changed places"
        set_table(goal)
