"""A pyramid of blocks and a chess board: what stands where, and what only lies or leans there."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS
from tests.tasks.goals.goal import Goal, goal_of
from tests.tasks.running import colors

PLACES = ((-0.042, 0.02), (0.0, 0.02), (0.042, 0.02), (-0.021, 0.06), (0.021, 0.06), (0.0, 0.1))
"""y and z of the middles of the blocks of a pyramid on the strip [m]."""


def pile(goal: Goal, names: list[str]) -> None:
    """Build a pyramid of these blocks, from the lowest row to the top."""
    for name, (y, z) in zip(names, PLACES, strict=False):
        goal.put(name, (0.0, y, z), on="strip")


@goal_of("block_pyramid", 0, 9, 19)
def test_a_pyramid_has_rows_of_three_two_and_one(goal: Goal) -> None:
    """Six blocks of the asked colour, let go; five, or one of the other colour at any place, are not enough."""
    variation = (0, 9, 19)[goal.asked([COLORS[i].name for i in (0, 9, 19)])]
    assert colors(goal.task, "block0", "block5") == [COLORS[variation].rgb] * 2
    assert colors(goal.task, "distractor0", "distractor5") != [COLORS[variation].rgb] * 2
    blocks = [f"block{i}" for i in range(6)]
    pile(goal, blocks[:5])
    assert not goal.reached()
    for k, (y, z) in enumerate(PLACES):
        pile(goal, blocks)
        assert goal.reached()
        goal.put(blocks[k], (0.4, 0.0, 0.02), on="strip")
        assert not goal.reached()
        goal.put("distractor0", (0.0, y, z), on="strip")
        assert not goal.reached()
        goal.put("distractor0", (0.4, 0.2, 0.02), on="strip")
    pile(goal, blocks)
    goal.needs_release_of("block5")


@goal_of("block_pyramid")
def test_the_rows_of_a_pyramid_are_upright_and_on_the_strip(goal: Goal) -> None:
    """Each block is in its row: not beside the strip, not on its edge in two rows, and not in a tower or flat on the table."""
    blocks = [f"block{i}" for i in range(6)]
    pile(goal, blocks)
    goal.ends("block5", (0.0, 0.0, 0.1), on="strip", x=(-0.035, 0.035), y=(-0.035, 0.035), z=(0.022,))
    goal.ends("block2", (0.0, 0.042, 0.02), on="strip", x=(-0.035, 0.035), y=(0.048,))
    pile(goal, blocks[:5])
    goal.put("block5", (0.0, 0.0, 0.0283), (np.pi / 4.0, 0.0, 0.0), on="strip")
    assert not goal.reached()
    for k, name in enumerate(blocks):
        goal.put(name, (0.0, 0.0, 0.02 + 0.04 * k), on="strip")
    assert not goal.reached()
    for k, name in enumerate(blocks):
        goal.put(name, (0.022 * (-1) ** k, 0.042 * (k // 2 - 1), 0.02), on="strip")
    assert not goal.reached()


@goal_of("setup_chess", 0, 1, 2)
def test_every_man_has_to_stand_on_its_square(goal: Goal) -> None:
    """Within 1.8 cm of its middle, let go; one fewer does not count, nor one that lies there or stands on another man."""
    stray = [goal.task.men[i].name for i in goal.task.stray]
    assert len(stray) == 1 + goal.asked(("one", "two", "three"))
    for name in stray:
        assert not goal.reached()
        goal.put(name, (0.0, 0.0, 0.0), on=f"foot_{name}")
    last, home = stray[-1], f"foot_{stray[-1]}"
    goal.ends(last, (0.0, 0.0, 0.0), on=home, x=(-0.019, 0.019), y=(-0.019, 0.019), within=1.5e-3)
    goal.needs_release_of(last)
    for turned in ((np.pi / 2.0, 0.0, 0.0), (0.0, np.pi / 2.0, 0.0)):
        goal.put(last, (0.0, 0.0, 0.018), turned, on=home)
        assert not goal.reached(), "it lies on its square"
    goal.put(last, (0.0, 0.0, 0.06), on=home)
    assert not goal.reached(), "it stands on something"
    goal.put(last, (0.0, 0.0, 0.0), on=home)


@goal_of("setup_chess", 1, 2)
def test_no_other_man_may_leave_or_fall(goal: Goal) -> None:
    """Each of the 32 stands at its home; men that look the same may change places only where both were stray."""
    for index in goal.task.stray:
        name = goal.task.men[index].name
        goal.put(name, (0.0, 0.0, 0.0), on=f"foot_{name}")
    assert goal.reached()
    for man in goal.task.men:
        home = f"foot_{man.name}"
        goal.put(man.name, (0.0, 0.0, 0.018), (np.pi / 2.0, 0.0, 0.0), on=home)
        assert not goal.reached(), f"{man.name} lies"
        goal.put(man.name, (0.0, 0.0, 0.0), on="stray")
        assert not goal.reached(), f"{man.name} is gone"
        goal.put(man.name, (0.0, 0.0, 0.0), on=home)
    assert goal.reached()
