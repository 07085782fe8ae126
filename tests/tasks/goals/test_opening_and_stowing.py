"""Objects that are put into, or taken out of, a fridge, an oven or a box that is shut at first."""

from __future__ import annotations

import numpy as np

from tests.tasks.goals.goal import Goal, goal_of

SHOES = ("shoe_left", "shoe_right")
FACE_DOWN = (np.pi, 0.0, 0.0)


@goal_of("put_bottle_in_fridge")
def test_the_bottle_has_to_stand_on_the_middle_shelf(goal: Goal) -> None:
    """Upright and let go; lying there, upside down, on another shelf, on the floor or before the fridge it does not count."""
    goal.joint("fridge/upper_door", 1.5)
    shelf = (0.0, 0.0, 0.305)
    refused = (
        ((0.0, 0.0, 0.335), (0.0, np.pi / 2.0, 0.0)),
        ((0.0, 0.0, 0.485), FACE_DOWN),
        ((0.0, 0.0, 0.365), (0.0, 0.0, 0.0)),
        ((0.0, 0.0, 0.313), (0.3, 0.0, 0.0)),  # leaning
        ((0.0, 0.0, 0.224), (0.0, 0.0, 0.0)),
        ((0.0, 0.0, 0.027), (0.0, 0.0, 0.0)),
        ((0.0, 0.0, 0.6), (0.0, 0.0, 0.0)),
        ((-0.25, 0.0, 0.0), (0.0, 0.0, 0.0)),
        ((-0.25, 0.0, 0.305), (0.0, 0.0, 0.0)),
    )
    for place, rpy in refused:
        goal.put("bottle", place, rpy, on="fridge")
        assert not goal.reached(), place
    goal.ends("bottle", shelf, on="fridge", x=(-0.07, 0.13), y=(-0.14, 0.14), z=(-0.005, 0.005))
    goal.needs_release_of("bottle")
    goal.joint("fridge/upper_door", 0.0)
    assert goal.reached()


@goal_of("put_tray_in_oven")
def test_the_tray_has_to_lie_on_the_grid_all_the_way_in(goal: Goal) -> None:
    """Let go; half in, aslant, tilted, upside down, on the floor of the oven, on its door or its top it does not count."""
    goal.joint("oven/door", 1.57)
    refused = (
        ((-0.12, 0.0, 0.16), (0.0, 0.0, 0.0)),
        ((-0.03, 0.0, 0.16), (0.0, 0.0, np.pi / 2.0)),
        ((-0.03, 0.0, 0.18), (0.0, 0.2, 0.0)),
        ((-0.03, 0.0, 0.18), FACE_DOWN),
        ((-0.03, 0.0, 0.1), (0.0, 0.0, 0.0)),
        ((-0.03, 0.0, 0.25), (0.0, 0.0, 0.0)),
        ((-0.03, 0.0, 0.428), (0.0, 0.0, 0.0)),
        ((-0.31, 0.0, 0.09), (0.0, 0.0, 0.0)),
    )
    for place, rpy in refused:
        goal.put("tray", place, rpy, on="oven")
        assert not goal.reached(), place
    goal.ends("tray", (0.0, 0.0, 0.16), on="oven", x=(-0.065, 0.09), y=(-0.085, 0.085), z=(-0.01, 0.02))
    goal.needs_release_of("tray")


@goal_of("take_tray_out_of_oven")
def test_the_tray_has_to_lie_on_the_table(goal: Goal) -> None:
    """Let go; in the oven, half out, on the open door, in the air, upside down or leaning it does not count."""
    goal.joint("oven/door", 1.57)
    table = (-0.22, -0.36, 0.0)
    refused = (
        ((-0.2, 0.0, 0.16), (0.0, 0.0, 0.0)),
        ((-0.04, 0.0, 0.1), (0.0, 0.0, 0.0)),
        ((-0.32, 0.0, 0.09), (0.0, 0.0, 0.0)),
        ((-0.4, 0.0, 0.3), (0.0, 0.0, 0.0)),
        ((-0.22, -0.36, 0.0273), (np.pi, 0.085, 0.0)),  # on its rear rim and its grip
        ((-0.22, -0.36, 0.03), (0.0, 0.3, 0.0)),
        ((-0.22, -0.36, 0.12), (np.pi / 2.0, 0.0, 0.0)),
    )
    for place, rpy in refused:
        goal.put("tray", place, rpy, on="oven")
        assert not goal.reached(), place
    goal.ends("tray", table, on="oven", z=(0.012,))
    for place in ((-0.22, 0.36, 0.0), (-0.6, 0.0, 0.0)):
        goal.put("tray", place, (0.0, 0.0, 1.0), on="oven")
        assert goal.reached()
    goal.needs_release_of("tray")


@goal_of("put_shoes_in_box")
def test_both_shoes_have_to_be_in_the_box(goal: Goal) -> None:
    """Whichever way up, let go; one of them, one on the rim or one on the lid does not count."""
    goal.joint("shoe_box/lid_hinge", 1.7)
    places = dict(zip(SHOES, ((0.0, 0.052, 0.005), (0.0, -0.052, 0.005)), strict=True))
    goal.put("shoe_left", places["shoe_left"], on="shoe_box")
    assert not goal.reached()
    for name in SHOES:
        goal.put("shoe_left", places["shoe_left"], on="shoe_box")
        goal.put("shoe_right", places["shoe_right"], on="shoe_box")
        assert goal.reached()
        refused = (
            ((0.0, 0.3, 0.0), (0.0, 0.0, 0.0)),
            ((0.0, 0.0, 0.1), (0.0, 0.0, 0.0)),
            ((-0.05, 0.05, 0.07), (0.0, 0.7, 0.0)),
            ((-0.09, 0.0, 0.05), (0.0, 0.0, 0.0)),
        )
        for place, rpy in refused:
            goal.put(name, place, rpy, on="shoe_box")
            assert not goal.reached(), place
        side = np.sign(places[name][1])
        goal.ends(name, places[name], on="shoe_box", x=(-0.03, 0.03), y=(side * 0.073,), z=(0.065,))
        for rpy in (FACE_DOWN, (np.pi / 2.0, 0.0, 0.0)):
            goal.put(name, (0.0, side * 0.052, 0.065), rpy, on="shoe_box")
            assert goal.reached()
        goal.needs_release_of(name)
    goal.joint("shoe_box/lid_hinge", 0.0)
    assert goal.reached()


@goal_of("take_shoes_out_of_box")
def test_both_shoes_have_to_lie_on_the_table(goal: Goal) -> None:
    """Whichever way up, let go; one of them, one in the air, on the lid, or leaning on the box does not count."""
    goal.joint("shoe_box/lid_hinge", 1.7)
    places = dict(zip(SHOES, ((0.0, 0.3, 0.0), (-0.2, 0.0, 0.0)), strict=True))
    goal.put("shoe_left", places["shoe_left"], on="shoe_box")
    assert not goal.reached()
    for name in SHOES:
        for shoe in SHOES:
            goal.put(shoe, places[shoe], on="shoe_box")
        assert goal.reached()
        refused = (
            ((0.0, 0.0, 0.005), (0.0, 0.0, 0.0)),
            ((0.0, 0.0, 0.1), (0.0, 0.0, 0.0)),
            ((0.0, 0.3, 0.1), (0.0, 0.0, 0.0)),
            ((-0.13, 0.05, 0.05), (0.0, -0.8, 0.0)),
        )
        for place, rpy in refused:
            goal.put(name, place, rpy, on="shoe_box")
            assert not goal.reached(), place
        goal.ends(name, places[name], on="shoe_box", z=(0.03,))
        for rpy, z in ((FACE_DOWN, 0.06), ((np.pi / 2.0, 0.0, 0.0), 0.0275)):
            goal.put(name, (*places[name][:2], z), rpy, on="shoe_box")
            assert goal.reached()
        goal.needs_release_of(name)
