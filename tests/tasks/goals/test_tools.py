"""Tools: a ball struck with a cue, a cube moved with a stick, a plant watered, a cube scooped up."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS
from tests.tasks.goals.goal import Goal, goal_of

IN_POCKET = (0.045, 0.0, 0.02)
OVER_POT = (-0.1515, 0.0, 0.033)
"""Where the can has its head over the pot."""


@goal_of("hit_ball_with_queue")
def test_the_cue_has_to_be_held_before_the_ball_is_in_the_pocket(goal: Goal) -> None:
    """A ball that lies there without it does not count; once the cue was held it may be let go."""
    goal.put("ball", IN_POCKET, on="goal")
    assert not goal.reached()
    goal.put("ball", (0.0, 0.06, 0.02))
    assert goal.task.gripper.grasp("cue")
    assert not goal.reached()
    goal.task.gripper.release()
    assert not goal.reached()
    goal.put("ball", IN_POCKET, on="goal")
    assert goal.reached()


@goal_of("hit_ball_with_queue")
def test_the_ball_has_to_be_inside_the_pocket(goal: Goal) -> None:
    """As a whole, its middle 2.5 cm behind the open side; half way in, beside, behind or on a wall it does not count."""
    assert goal.task.gripper.grasp("cue")
    for place in ((-0.012, 0.0, 0.02), (-0.1, 0.0, 0.02), (0.04, 0.075, 0.02), (0.04, -0.075, 0.02), (0.105, 0.0, 0.02)):
        goal.put("ball", place, on="goal")
        assert not goal.reached(), place
    for place in ((0.04, 0.0, 0.058), (0.078, 0.0, 0.07), (0.04, 0.046, 0.07)):
        goal.put("ball", place, on="goal")
        assert not goal.reached(), place
    goal.put("ball", (0.024, 0.0, 0.02), on="goal")
    assert not goal.reached()
    goal.put("ball", (0.026, 0.0, 0.02), on="goal")
    assert goal.reached()


@goal_of("reach_and_drag", *range(len(COLORS)))
def test_the_cube_has_to_reach_the_middle_of_the_square(goal: Goal) -> None:
    """Its side within 2.5 cm of it; the square has the colour that the sentence names."""
    assert goal.task.world.body("target").color[:3] == COLORS[goal.asked([color.name for color in COLORS])].rgb
    goal.ends("cube", (0.0, 0.0, 0.025), on="target", x=(-0.05, 0.05), y=(-0.05, 0.05), z=(0.02,))


@goal_of("reach_and_drag")
def test_the_stick_does_not_count_for_the_cube(goal: Goal) -> None:
    """The stick on the square is not the deed; with the cube on it, the stick may still be held."""
    goal.put("stick", (0.0, 0.0, 0.012), on="target")
    assert not goal.reached()
    goal.put("cube", (0.0, 0.055, 0.025), on="target")
    assert not goal.reached()
    goal.put("cube", (0.0, 0.04, 0.025), on="target")
    goal.counts_while_held("stick")


def pour(goal: Goal) -> list[str]:
    """Hold the head of the can over the pot for one tick, and return the drops that come out."""
    goal.put("can", OVER_POT, on="plant")
    goal.tick()
    return [name for name in goal.world.bodies if name.startswith("drop")]


@goal_of("water_plants")
def test_five_drops_come_out_where_the_head_is_over_the_pot(goal: Goal) -> None:
    """Once; not beside the pot, and not with the can as a whole in the pot."""
    for offset in ((0.0, 0.021, 0.0), (-0.021, 0.0, 0.0), (0.021, 0.0, 0.0), (0.0, 0.0, 0.021), (0.1515, 0.0, 0.05)):
        goal.put("can", np.add(OVER_POT, offset), on="plant")
        goal.tick()
        assert "drop0" not in goal.world.bodies
        assert not goal.reached()
    drops = pour(goal)
    assert len(drops) == 5
    assert not goal.reached()
    places = np.array([goal.world.body(drop).position for drop in drops])
    assert np.linalg.norm(places - goal.world.frame("head").position, axis=1).max() < 0.02
    assert len(pour(goal)) == 5
    for drop in drops:
        goal.put(drop, (0.0, 0.0, 0.075), on="plant")
    goal.tick()
    assert goal.reached()


@goal_of("water_plants")
def test_every_drop_has_to_lie_on_the_soil(goal: Goal) -> None:
    """All five of them, inside the pot; on its rim, beside it, in the air over it or on the can they do not count."""
    drops = pour(goal)
    for drop in drops:
        assert not goal.reached()
        goal.put(drop, (-0.02, 0.0, 0.075), on="plant")
        goal.tick()
    assert goal.reached()
    for drop in drops:
        for place in ((-0.057, 0.0, 0.105), (-0.08, 0.0, 0.005), (-0.02, 0.0, 0.12)):
            goal.put(drop, place, on="plant")
            goal.tick()
            assert not goal.reached(), place
        goal.put(drop, (-0.02, 0.0, 0.075), on="plant")
    goal.tick()
    assert goal.reached()


@goal_of("scoop_with_spatula")
def test_the_cube_has_to_be_in_the_air_while_the_spatula_is_held(goal: Goal) -> None:
    """8 cm over its place; lower, or with the spatula let go, it does not count."""
    goal.put("cube", (0.075, 0.0, 0.1325))
    assert not goal.reached()
    assert goal.task.gripper.grasp("spatula")
    goal.ends("cube", (0.075, 0.0, 0.1325), x=(-0.1125, 0.1125), y=(-0.1125, 0.1125), z=(-0.0525, 0.0525), within=2e-3)
    for place in ((0.075, 0.0, 0.0125), (0.04, 0.0, 0.02), (0.075, 0.0, 0.06), (-0.2, 0.0, 0.1)):
        goal.put("cube", place)
        assert not goal.reached(), place
    goal.task.gripper.release()
    goal.put("cube", (0.075, 0.0, 0.1325))
    assert not goal.reached()
    assert goal.task.gripper.grasp("spatula")
    assert goal.reached()
