"""Towers and boards: which pieces, how many, and that the others stay."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS
from tests.tasks.goals.goal import Goal, goal_of
from tests.tasks.running import begin, colors, running


def stack(goal: Goal, names: list[str], lowest: int = 0) -> None:
    """Put blocks one on another on the green square."""
    for k, name in enumerate(names):
        goal.put(name, (0.0, 0.0, 0.025 + 0.05 * (lowest + k)), on="square")


@goal_of("stack_blocks", 0, 4, 59)
def test_a_tower_has_to_have_the_asked_height_and_colour(goal: Goal) -> None:
    """Two to four blocks of the colour on another, let go; any of the four will do, the others do not count."""
    variation = (0, 4, 59)[goal.asked(("two", "three", "four"))]
    height = 2 + variation % 3
    assert colors(goal.task, "block0", "block3") == [COLORS[variation // 3].rgb] * 2
    assert len(set(colors(goal.task, *(f"distractor{i}" for i in range(4))))) == 1
    blocks = [f"block{i}" for i in range(4)]
    stack(goal, [*blocks[: height - 1], "distractor0"])
    assert not goal.reached()
    goal.put("distractor0", (0.0, 0.2, 0.025))
    top = blocks[3]
    place = (0.0, 0.0, 0.05 * height - 0.025)
    goal.ends(top, place, on="square", x=(-0.0275, 0.0275), y=(-0.0275, 0.0275), z=(-0.03, 0.03), within=3e-4)
    goal.needs_release_of(top)
    goal.put(blocks[height - 2], (0.2, 0.2, 0.025))
    goal.put(top, (0.0, 0.0, 0.05 * height - 0.0645), (np.pi / 4.0, 0.0, 0.0), on="square")  # on its edge it fills two levels
    assert not goal.reached()
    stack(goal, [*blocks[: height - 1], top])
    stack(goal, ["distractor0"], lowest=height)
    assert goal.reached()


@goal_of("stack_blocks", 2, 31, 57)
def test_blocks_side_by_side_are_no_tower(goal: Goal) -> None:
    """All four around the middle of the square, in two layers, or on a block of the other colour."""
    height = 2 + goal.asked(("two", "three", "four"))
    for layers in ((0, 0, 0, 0), (0, 0, 0, 1)):
        for k, ((x, y), layer) in enumerate(zip(((1, 1), (1, -1), (-1, 1), (-1, -1)), layers, strict=True)):
            goal.put(f"block{k}", (0.0255 * x, 0.0255 * y, 0.025 + 0.05 * layer), on="square")
        assert goal.reached() is (height == 1 + max(layers))
    blocks = [f"block{i}" for i in range(4)]
    stack(goal, ["distractor0"])
    stack(goal, blocks[:height], lowest=1)
    for spare in blocks[height:]:
        goal.put(spare, (0.2, 0.2, 0.025))
    assert not goal.reached()
    stack(goal, blocks[:height])
    assert goal.reached()


def test_stack_blocks_retargets_its_waypoints_every_round() -> None:
    """The next block, a higher tower, and no retreat after the last."""
    with running("stack_blocks") as task:
        begin(task, 2)
        heights, skips = [], []
        for k in range(4):
            points = task.get_waypoints()
            for i in (0, 3, 5):
                points[i].run_start_hook()
            np.testing.assert_allclose(points[1].pose[:3], task.world.body(f"block{k}").position, atol=1e-9)
            heights.append(points[3].pose[2] - task.world.body("square").position[2])
            skips.append(points[5].skip)
            assert task.should_repeat_waypoints() == (k < 3)
        np.testing.assert_allclose(heights, [0.08, 0.13, 0.18, 0.23])
        assert skips == [False, False, False, True]


@goal_of("tower4", 0, 1, 3, 9)
def test_a_tower_of_four_has_to_have_its_colours_in_the_asked_order(goal: Goal) -> None:
    """From the bottom up, let go; not with two swapped, upside down, of three, or with a block of the fifth colour."""
    blocks = [f"block{i}" for i in range(4)]
    palette = {color.rgb: color.name for color in COLORS}
    a, b, c, d = (palette[color] for color in colors(goal.task, *blocks))
    assert goal.says(f"{a}_at_the_bottom_then_{b}_then_{c}_and_{d}_at_the_top")
    (other,) = set(colors(goal.task, *(f"distractor{i}" for i in range(4))))
    assert palette[other] not in (a, b, c, d)
    for order in ((1, 0, 2, 3), (0, 1, 3, 2), (3, 2, 1, 0)):
        stack(goal, [blocks[i] for i in order])
        assert not goal.reached(), order
    stack(goal, [*blocks[:3], "distractor0"])
    goal.put("block3", (0.2, 0.2, 0.025))
    assert not goal.reached()
    goal.put("distractor0", (0.0, 0.2, 0.025))
    assert not goal.reached()
    stack(goal, blocks)
    goal.ends("block3", (0.0, 0.0, 0.175), on="square", x=(-0.0275, 0.0275), y=(-0.0275, 0.0275), z=(-0.03, 0.03), within=3e-4)
    goal.needs_release_of("block3")
    for name, height in zip(blocks, (0.025, 0.075, 0.125, 0.175), strict=True):
        goal.put(name, (0.1, 0.0, height), on="square")
    assert not goal.reached()
    stack(goal, blocks)
    stack(goal, ["distractor0"], lowest=4)
    assert goal.reached()


def test_the_two_halves_of_the_variations_of_tower4_are_opposite() -> None:
    """The same colours, in the opposite order; no colour is in two of the first five."""
    with running("tower4") as task:
        clean, found = task.world.save(), []
        for variation in range(10):
            task.world.restore(clean)
            begin(task, variation)
            found.append(colors(task, "block0", "block1", "block2", "block3"))
    assert [list(reversed(order)) for order in found[:5]] == found[5:]
    assert len({color for order in found[:5] for color in order}) == len(COLORS)


@goal_of("play_jenga")
def test_the_loose_brick_has_to_come_right_out(goal: Goal) -> None:
    """All of it 9.5 cm from the middle of the tower, whichever way, and let go."""
    reach = 0.095 + 0.04875
    for direction in (-1.0, 1.0):
        goal.border(
            lambda x, d=direction: goal.put("target", (d * x, 0.0327, 0.00975)), inside=reach + 0.001, outside=reach - 0.001
        )
    goal.border(lambda y: goal.put("target", (0.0, y, 0.00975)), inside=0.1123, outside=0.1103)
    goal.put("target", (-0.2, 0.0327, 0.00975))
    goal.needs_release_of("target")


@goal_of("play_jenga")
def test_every_other_brick_has_to_stay(goal: Goal) -> None:
    """One that lies beside the tower, flat or leaning, has fallen; so has one pushed out by 17 mm, not by 15."""
    goal.put("target", (-0.2, 0.0327, 0.00975))
    assert goal.reached()
    for i in range(13):
        name = f"brick{i}"
        place = goal.world.body(name).pose
        for fallen in ((0.0, 0.0657, 0.00975, 0.0), (0.0, -0.0657, 0.00975, 0.0), (0.0657, 0.0, 0.00975, np.pi / 2.0)):
            goal.put(name, fallen[:3], (0.0, 0.0, fallen[3]))
            assert not goal.reached(), name
        goal.put(name, (0.0, 0.085, 0.039), (np.deg2rad(60.0), 0.0, 0.0))
        assert not goal.reached(), name
        goal.world.body(name).set_pose(place)
        assert goal.reached()
    goal.ends("brick12", (0.0, 0.0327, 0.08775), y=(0.01605,), x=(-0.08125, 0.08125))


@goal_of("setup_checkers", 0, 1, 2)
def test_every_square_has_to_have_its_piece(goal: Goal) -> None:
    """Within 2.5 cm of its middle, lying on the board and not on another piece, let go; one fewer does not count."""
    loose = list(goal.task.missing)
    assert len(loose) == 1 + goal.asked(("one", "two", "three"))
    for index in loose:
        assert not goal.reached()
        goal.put(f"piece{index}", (0.0, 0.0, 0.001), on=f"square{index}")
    last = f"piece{loose[-1]}"
    goal.ends(last, (0.0, 0.0, 0.001), on=f"square{loose[-1]}", x=(-0.025, 0.025), y=(-0.025, 0.025), z=(0.009,), within=5e-4)
    goal.needs_release_of(last)
    for i in range(24):
        for place, on in (((0.0, 0.0, 0.013), f"square{i}"), ((0.0, 0.3, 0.006), "root")):
            goal.put(f"piece{i}", place, on=on)
            assert not goal.reached()
        goal.put(f"piece{i}", (0.0, 0.0, 0.001), on=f"square{i}")
    assert goal.reached()


@goal_of("setup_checkers", 1, 2)
def test_loose_pieces_of_one_colour_may_change_places(goal: Goal) -> None:
    """They look the same; a light one on a dark one's square does not count, nor do two on one square."""
    loose = goal.task.missing
    for turn in range(len(loose)):
        squares = loose[turn:] + loose[:turn]
        for piece, square in zip(loose, squares, strict=True):
            goal.put(f"piece{piece}", (0.0, 0.0, 0.001), on=f"square{square}")
        alike = all((piece < 12) == (square < 12) for piece, square in zip(loose, squares, strict=True))
        assert goal.reached() is alike
    for piece in loose:
        goal.put(f"piece{piece}", (0.0, 0.0, 0.001), on=f"square{loose[0]}")
    assert not goal.reached()
