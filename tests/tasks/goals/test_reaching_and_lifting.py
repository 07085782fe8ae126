"""Places that the tip, or what is held, has to reach."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.spatial import TABLE_HEIGHT
from rlbench_pin.tasks import COLORS
from tests.tasks.goals.goal import Goal, goal_of
from tests.tasks.running import begin, colors, running


def asked_color(goal: Goal) -> int:
    """Return the number of the colour that the instructions name."""
    return goal.asked([color.name for color in COLORS])


def test_reach_target_colours_and_spreads_its_balls() -> None:
    """Three colours, 20 cm apart."""
    with running("reach_target") as task:
        begin(task, 4)
        names = ("target", "distractor0", "distractor1")
        seen = colors(task, *names)
        assert seen[0] == COLORS[4].rgb
        assert len(set(seen)) == 3
        places = [task.world.body(n).position for n in names]
        assert min(np.linalg.norm(places[i] - places[j]) for i in range(3) for j in range(i)) >= 0.2
        np.testing.assert_array_equal(task.get_low_dim_state(), places[0])


@goal_of("reach_target", 0, 10, 19)
def test_the_tip_has_to_be_in_the_asked_ball(goal: Goal) -> None:
    """Within its radius of 2.5 cm; another ball does not count."""
    tip = goal.task.robot.tip_pose()[:3]
    assert colors(goal.task, "target") == [COLORS[asked_color(goal)].rgb]
    goal.put("distractor0", tip, on="world")
    assert not goal.reached()
    goal.ends("target", tip, on="world", x=(-0.025, 0.025), y=(-0.025, 0.025), z=(-0.025, 0.025))
    goal.put("target", tip + [0.0, 0.0, 0.02], on="world")
    assert goal.task.reward() == pytest.approx(-0.02)


@goal_of("pick_and_lift", 0, 10, 19)
def test_the_asked_block_has_to_be_held_at_the_marker(goal: Goal) -> None:
    """Its side may touch a ball of 6 cm in the ring; free or another block is no success."""
    assert colors(goal.task, "block") == [COLORS[asked_color(goal)].rgb]
    assert goal.task.marker.position[2] == pytest.approx(TABLE_HEIGHT + 0.2)
    goal.put("block", (0.0, 0.0, 0.0), on="marker")
    assert not goal.reached()
    assert goal.task.gripper.grasp("distractor0")
    assert not goal.reached()
    goal.task.gripper.release()
    assert goal.task.gripper.grasp("block")
    goal.ends("block", (0.0, 0.0, 0.0), on="marker", x=(-0.0525, 0.0525), y=(-0.0525, 0.0525), z=(-0.0525, 0.0525))
    goal.put("block", (0.1, 0.0, 0.0), on="marker")
    goal.put("distractor0", (0.0, 0.0, 0.0), on="marker")
    assert not goal.reached()


def ends_at_marker(goal: Goal, word: str, **borders: tuple[float, ...]) -> None:
    """Check that the toy that is asked for by this word has to be held at the marker; free, or another body is no success."""
    assert goal.says(word)
    goal.put("toy", (0.0, 0.0, 0.0), on="marker")
    assert not goal.reached()
    assert goal.task.gripper.grasp("distractor0")
    assert not goal.reached()
    goal.task.gripper.release()
    assert goal.task.gripper.grasp("toy")
    goal.ends("toy", (0.0, 0.0, 0.0), on="marker", **borders)
    goal.put("toy", (0.1, 0.0, 0.0), on="marker")
    goal.put("distractor0", (0.0, 0.0, 0.0), on="marker")
    assert not goal.reached()


@goal_of("pick_and_lift_cylinder")
def test_the_cylinder_has_to_be_held_at_the_marker(goal: Goal) -> None:
    """It may touch a ball of 6 cm in the ring from any side."""
    ends_at_marker(goal, "cylinder", x=(-0.0527, 0.0527), y=(-0.0527, 0.0527), z=(-0.0625, 0.0625))


@goal_of("pick_and_lift_star")
def test_the_star_has_to_be_held_at_the_marker(goal: Goal) -> None:
    """It may touch a ball of 6 cm in the ring from above or below; its mesh has a skin of 1 mm."""
    ends_at_marker(goal, "star", z=(-0.0612, 0.0612))


@goal_of("pick_and_lift_moon")
def test_the_moon_has_to_be_held_at_the_marker(goal: Goal) -> None:
    """It may touch a ball of 6 cm in the ring from above or below; its mesh has a skin of 1 mm."""
    ends_at_marker(goal, "crescent moon", z=(-0.0612, 0.0612))


@goal_of("pick_and_lift_toy")
def test_the_duck_has_to_be_held_at_the_marker(goal: Goal) -> None:
    """It may touch a ball of 6 cm in the ring, with its bottom as with its head."""
    ends_at_marker(goal, "rubber duck", z=(0.029,))
    goal.put("distractor0", (0.2, 0.2, 0.0225))
    goal.ends("toy", (-0.015, 0.0, -0.051), on="marker", z=(-0.049,), within=2e-3)


@goal_of("take_lid_off_saucepan")
def test_the_lid_has_to_be_held_high_over_the_pan(goal: Goal) -> None:
    """Not free in the air, not held lower or beside the pan; the reward counts the ways of the gripper and of the knob."""
    lid, above = goal.task.lid, goal.task.above.position
    to_tip = np.linalg.norm(goal.task.robot.tip_pose()[:3] - lid.position)
    assert goal.task.reward() == pytest.approx(-to_tip - np.linalg.norm(lid.position - above))
    assert goal.task.gripper.grasp("lid")
    assert not goal.reached()
    goal.task.gripper.release()
    goal.put("lid", (0.0, 0.0, 0.0), on="above")
    assert not goal.reached()
    assert goal.task.gripper.grasp("lid")
    goal.ends("lid", (0.0, 0.0, 0.0), on="above", x=(-0.15, 0.15), y=(-0.15, 0.15), z=(-0.0425, 0.0645))


@goal_of("beat_the_buzz")
def test_the_wand_has_to_be_let_go_at_the_far_end(goal: Goal) -> None:
    """Its ring is there from 9 to 16 cm along the rod."""
    goal.ends("wand", (0.12, 0.0, 0.155), on="base", x=(-0.03, 0.04))
    goal.needs_release_of("wand")
    goal.put("wand", (0.12, 0.0, 0.245), on="base")
    assert not goal.reached()


@goal_of("beat_the_buzz")
def test_touching_the_live_rod_ends_the_game(goal: Goal) -> None:
    """A ring 18 mm off the middle does not touch it, one 20 mm off does, in every direction; at the ends it may."""
    for y, z in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        for off, touches in ((0.018, False), (0.020, True)):
            goal.put("wand", (0.0, off * y, 0.155 + off * z), on="base")
            assert goal.lost() is touches
    goal.put("wand", (-0.12, 0.0, 0.175), on="base")
    assert not goal.reached()
    goal.put("wand", (0.12, 0.0, 0.175), on="base")
    assert goal.reached()


@goal_of("lift_numbered_block", 0, 1, 2)
def test_the_asked_number_has_to_be_held_in_the_air(goal: Goal) -> None:
    """From 12 to 22 cm above the table; neither let go nor on the table, and not another number."""
    number, hand = 1 + goal.asked(("1", "2", "3")), goal.task.gripper
    for other in {1, 2, 3} - {number}:
        assert hand.grasp(f"block{other}")
        goal.put(f"block{other}", (0.0, 0.1 * other, 0.0), on="height")
        assert not goal.reached()
        hand.release()
    goal.put(f"block{number}", (0.0, 0.0, 0.0), on="height")
    assert not goal.reached()
    assert hand.grasp(f"block{number}")
    goal.ends(f"block{number}", (0.0, 0.0, 0.0), on="height", z=(-0.0825, 0.0825))
    goal.put(f"block{number}", (0.0, 0.0, 0.0325))
    assert not goal.reached()


@goal_of("pick_and_lift_small", 0, 2, 4)
def test_the_asked_shape_has_to_be_held_at_the_marker(goal: Goal) -> None:
    """It may touch a ball of 6 cm from above or below; neither let go nor another shape, and not beside it."""
    shapes, hand = goal.task.shapes, goal.task.gripper
    number = goal.asked(goal.task.words)
    asked, half = shapes[number], (0.0175, 0.0125, 0.0115, 0.0115, 0.0115)[number]  # meshes have a skin of 1 mm
    for other in (shape for shape in shapes if shape != asked):
        assert hand.grasp(other)
        goal.put(other, (0.0, 0.0, 0.0), on="marker")
        assert not goal.reached()
        hand.release()
        goal.put(other, (0.2, 0.2, 0.02))
    goal.put(asked, (0.0, 0.0, 0.0), on="marker")
    assert not goal.reached()
    assert hand.grasp(asked)
    goal.ends(asked, (0.0, 0.0, 0.0), on="marker", z=(-0.03 - half, 0.03 + half))
    goal.put(asked, (0.07, 0.0, 0.0), on="marker")
    assert not goal.reached()


@goal_of("pick_up_cup", 0, 10, 19)
def test_the_asked_cup_has_to_be_held_clear_of_its_place(goal: Goal) -> None:
    """12 cm above it, or beside it 5 cm up; neither let go nor the other cup, not where it stood, and not dragged."""
    assert colors(goal.task, "cup") == [COLORS[asked_color(goal)].rgb]
    hand = goal.task.gripper
    assert hand.grasp("distractor")
    assert not goal.reached()
    goal.put("distractor", (0.0, 0.0, 0.2), on="start_zone")
    assert not goal.reached()
    hand.release()
    assert hand.grasp("cup")
    assert not goal.reached()
    goal.ends("cup", (0.0, 0.0, 0.1), on="start_zone", z=(-0.04,))
    goal.ends("cup", (0.15, 0.0, 0.01), on="start_zone", within=2e-3, x=(-0.048,), z=(-0.02,))
    hand.release()
    assert not goal.reached()
    assert hand.grasp("distractor")
    assert not goal.reached()
