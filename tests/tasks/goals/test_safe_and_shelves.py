"""Money in and out of a safe, books on shelves, and everything into a cupboard."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks.library.put_all_groceries_in_cupboard import ITEMS
from tests.tasks.goals.goal import Goal, goal_of

FLOORS = {"bottom": 0.02, "middle": 0.14, "top": 0.26}
"""Heights of the levels of the safe [m]."""
ON_EDGE, ON_END = (np.pi / 2.0, 0.0, 0.0), (0.0, np.pi / 2.0, 0.0)
UPSIDE_DOWN = (np.pi, 0.0, 0.0)


def level_of(goal: Goal) -> str:
    """Return the level that the first instruction names."""
    return tuple(FLOORS)[goal.asked(tuple(FLOORS))]


@goal_of("put_money_in_safe", 0, 1, 2)
def test_the_bundle_has_to_lie_on_the_asked_level(goal: Goal) -> None:
    """Let go, whichever way up; on another level, on the safe, under it or half out of it does not count."""
    floor = FLOORS[level_of(goal)]
    others = [(-0.05, 0.0, z + 0.01) for z in FLOORS.values() if z != floor]
    for place in (*others, (0.0, 0.0, 0.41), (-0.25, 0.0, 0.01), (-0.14, 0.0, floor + 0.01), (-0.05, 0.2, floor + 0.01)):
        goal.put("money", place, on="safe")
        assert not goal.reached(), place
    place = (0.02, 0.0, floor + 0.01)
    goal.ends("money", place, on="safe", x=(-0.14, 0.14), y=(-0.1375, 0.1375), z=(0.04,))
    for height, rpy in ((0.0275, ON_EDGE), (0.01, UPSIDE_DOWN)):
        goal.put("money", (0.0, 0.0, floor + height), rpy, on="safe")
        assert goal.reached()
    goal.needs_release_of("money")


@goal_of("put_cube_in_safe")
def test_the_cube_has_to_lie_in_the_safe(goal: Goal) -> None:
    """On any level, let go; on the safe, beside it, before it or half out of it does not count."""
    for place in ((0.0, 0.0, 0.42), (-0.25, 0.0, 0.02), (-0.14, 0.0, 0.04), (-0.13, 0.0, 0.16), (0.0, 0.2, 0.02)):
        goal.put("cube", place, on="safe")
        assert not goal.reached(), place
    for floor in FLOORS.values():
        goal.ends("cube", (0.02, 0.0, floor + 0.02), on="safe", x=(-0.11, 0.11), y=(-0.13, 0.13), z=(0.04,))
        goal.needs_release_of("cube")


@goal_of("take_money_out_safe", 0, 1, 2)
def test_the_asked_bundle_has_to_lie_on_the_table(goal: Goal) -> None:
    """Let go in front of the safe; another bundle, one that stays, and one over the table or laid elsewhere do not count."""
    level = level_of(goal)
    other = next(name for name in FLOORS if name != level)
    grasp = goal.task.get_waypoints()[1].pose
    assert np.linalg.norm(grasp[:3] - goal.world.body(f"money_{level}").position) < 0.05
    home = goal.place_of(f"money_{level}")
    assert abs(home[2] - goal.place_of("safe")[2] - FLOORS[level] - 0.01) < 2e-3
    goal.put(f"money_{other}", (-0.29, 0.0, 0.01), on="safe")
    assert not goal.reached()
    for place in ((-0.29, 0.0, 0.2), (-0.29, 0.3, 0.01), (0.3, 0.0, 0.01), (0.0, 0.0, 0.41)):
        goal.put(f"money_{level}", place, on="safe")
        assert not goal.reached(), place
    goal.ends(f"money_{level}", (-0.29, 0.0, 0.01), on="safe", x=(-0.185, 0.185), y=(-0.1525, 0.1525), z=(0.05,))
    goal.needs_release_of(f"money_{level}")


@goal_of("put_books_on_bookshelf", 0, 1, 2)
def test_as_many_books_as_asked_have_to_be_on_the_upper_board(goal: Goal) -> None:
    """Any of them, standing or lying, let go; on the lower board, before the shelf or over it they do not count."""
    count = 1 + goal.asked(("one", "two", "three"))
    names = ("book_yellow", "book_blue", "book_red")[:count]
    for number, name in enumerate(names):
        assert not goal.reached()
        for place in ((-0.15, 0.0, 0.065), (-0.02, 0.0, 0.48), (-0.02, 0.1 * number, 0.115), (0.0, 0.3, 0.315)):
            goal.put(name, place, on="shelf")
            assert not goal.reached(), place
        goal.put(name, (-0.02, 0.1 - 0.1 * number, 0.315), on="shelf")
    middle = (-0.01, 0.0, 0.315)
    goal.ends(names[0], middle, on="shelf", x=(-0.105, 0.105), y=(-0.1825, 0.1825), z=(0.105,))
    for height, rpy in ((0.0125, ON_EDGE), (0.045, ON_END), (0.065, UPSIDE_DOWN)):
        goal.put(names[0], (-0.01, 0.0, 0.25 + height), rpy, on="shelf")
        assert goal.reached(), rpy
    for name in names:
        goal.needs_release_of(name)


@goal_of("put_books_at_shelf_location", 0, 1, 2, 3)
def test_both_books_have_to_be_in_the_asked_compartment(goal: Goal) -> None:
    """Both, let go; one of them, or both in another compartment, before the case or on its partition, do not count."""
    heights, sides = {"upper": 0.25, "lower": 0.03}, {"left": 1.0, "right": -1.0}
    board = next(z for word, z in heights.items() if goal.says(word))
    side = next(s for word, s in sides.items() if goal.says(word))
    for z in heights.values():
        for s in sides.values():
            for number, name in enumerate(("book_blue", "book_red")):
                goal.put(name, (-0.03, s * (0.09 + 0.08 * number), z + 0.065), on="bookcase")
            assert goal.reached() == ((z, s) == (board, side))
    places = {"book_blue": (-0.01, side * 0.09, board + 0.065), "book_red": (-0.01, side * 0.18, board + 0.065)}
    for name, place in places.items():
        goal.put(name, place, on="bookcase")
    for name, place in places.items():
        middle = (-0.01, side * 0.135, board + 0.065)
        goal.ends(name, middle, on="bookcase", x=(-0.105, 0.105), y=(-0.1025, 0.1025))
        for wrong in ((-0.25, side * 0.135, 0.065), (-0.01, side * 0.35, 0.065), (-0.01, side * 0.135, board + 0.18)):
            goal.put(name, wrong, on="bookcase")
            assert not goal.reached(), wrong
        goal.put(name, (-0.01, side * 0.135, board + 0.0125), ON_EDGE, on="bookcase")
        assert goal.reached()
        goal.put(name, place, on="bookcase")
        goal.needs_release_of(name)


@goal_of("put_all_groceries_in_cupboard")
def test_all_seven_items_have_to_be_on_the_shelves(goal: Goal) -> None:
    """On either shelf, whichever way up, let go; one that is missing is enough to fail."""
    sizes = {name: goal.world.body(name).bounds()[1] for name in ITEMS}
    for number, name in enumerate(ITEMS):
        assert not goal.reached()
        z = (0.165, 0.4075)[number % 2] + sizes[name][2]
        goal.put(name, (0.0, -0.15 + 0.05 * number, z), on="cupboard")
    assert goal.reached()
    for name, size in sizes.items():
        for place in ((0.0, 0.0, size[2]), (0.0, 0.0, 0.65 + size[2]), (-0.14 - size[0], 0.0, size[2]), (0.0, 0.3, size[2])):
            goal.put(name, place, on="cupboard")
            assert not goal.reached(), (name, place)
        x, y = np.array([0.0975, 0.19]) + size[:2]
        goal.ends(name, (-0.0075, 0.0, 0.265), on="cupboard", x=(-x, x), y=(-y, y), z=(-0.08 - size[2], 0.35 + size[2]))
        for rpy in (ON_EDGE, ON_END, UPSIDE_DOWN):
            goal.put(name, (-0.0075, 0.0, 0.165 + size.max()), rpy, on="cupboard")
            assert goal.reached(), (name, rpy)
        goal.needs_release_of(name)
