"""Doors, lids and drawers: how far they have to move."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.tasks import BodySpec
from tests.tasks.goals.goal import Goal, goal_of


@goal_of("close_drawer", 0, 1, 2)
def test_the_asked_drawer_has_to_go_in(goal: Goal) -> None:
    """It alone stands out, by 10 cm, and counts from 6 cm inwards on; farther out is as little as what the others do."""
    drawers = ("bottom", "middle", "top")
    asked = drawers[goal.asked(drawers)]
    assert [goal.world.joint(f"chest/drawer_{name}").position for name in drawers] == [0.1 * (name == asked) for name in drawers]
    ahead, front = goal.place_of("waypoint0"), goal.place_of(f"chest/drawer_{asked}_link")
    assert abs(ahead[2] - front[2]) < 0.02 and np.linalg.norm(ahead[:2] - front[:2]) < 0.15
    for other in set(drawers) - {asked}:
        for way in (0.15, 0.0):
            goal.joint(f"chest/drawer_{other}", way)
            assert not goal.reached()
    drawer = goal.world.joint(f"chest/drawer_{asked}")
    goal.joint(drawer.name, drawer.upper)
    assert not goal.reached()
    goal.border(lambda way: goal.joint(drawer.name, 0.1 - way), inside=0.0605, outside=0.0595)
    goal.joint(drawer.name, 0.0)
    assert goal.reached()


@goal_of("close_microwave", also=["close_microwave2"])
def test_the_microwave_is_shut_by_forty_degrees(goal: Goal) -> None:
    """The door starts at 1.2 rad and stays there until it is pushed; opening it further is nothing."""
    door = goal.world.joint("microwave/door")
    for _ in range(20):
        goal.world.step()
    assert door.position == pytest.approx(1.2, abs=1e-3)
    goal.joint(door.name, door.upper)
    assert not goal.reached()
    goal.border(lambda angle: goal.joint(door.name, 1.2 - np.deg2rad(angle)), inside=40.2, outside=39.8)
    goal.joint(door.name, 0.0)
    assert goal.reached()


@goal_of("open_box", also=["open_box2"])
def test_the_lid_has_to_pass_upright(goal: Goal) -> None:
    """At 90 degrees it would fall shut again."""
    goal.border(lambda angle: goal.joint("carton/lid_hinge", np.deg2rad(angle)), inside=90.2, outside=89.8)


@goal_of("open_door", also=["open_door2"])
def test_the_door_has_to_swing_by_twenty_five_degrees(goal: Goal) -> None:
    """Turning the lever alone is not enough."""
    goal.joint("door/lever", 0.8)
    goal.tick()
    assert not goal.reached()
    goal.border(lambda angle: goal.joint("door/leaf_hinge", np.deg2rad(angle)), inside=25.2, outside=24.8)


@goal_of("open_door", also=["open_door2"])
def test_the_leaf_is_held_until_the_lever_was_down(goal: Goal) -> None:
    """24.8 degrees do not free it, 25.2 do, and a lever that has sprung back does not hold it again."""
    leaf = goal.world.joint("door/leaf_hinge")
    for angle, held in ((24.8, True), (25.2, False), (0.0, False)):
        goal.joint("door/lever", np.deg2rad(angle))
        goal.tick()
        assert leaf.locked is held
        assert not goal.reached()
    goal.joint(leaf.name, 1.0)
    assert goal.reached()


@goal_of("open_drawer", 0, 1, 2, also=["open_drawer2", "open_drawer3"])
def test_the_asked_drawer_has_to_come_out(goal: Goal) -> None:
    """By 15 cm; the grasp goes to its handle, the others do not count, pushed back is undone."""
    drawers = ("bottom", "middle", "top")
    asked = drawers[goal.asked(drawers)]
    np.testing.assert_allclose(goal.task.get_waypoints()[1].pose, goal.place_of(f"handle_{asked}"), atol=1e-9)
    for other in set(drawers) - {asked}:
        goal.joint(f"chest/drawer_{other}", 0.2)
    assert not goal.reached()
    goal.border(lambda way: goal.joint(f"chest/drawer_{asked}", way), inside=0.1505, outside=0.1495)


@goal_of("open_drawer_long", 0, 1, 2, 3)
def test_the_asked_one_of_four_drawers_has_to_come_out(goal: Goal) -> None:
    """Variations go from the bottom to the top; by 15 cm, the others do not count."""
    drawers = ("bottom", "lower_middle", "upper_middle", "top")
    assert goal.task.drawers == drawers  # type: ignore[attr-defined]
    asked = drawers[goal.asked(drawers)]
    heights = [goal.place_of(f"chest/drawer_{name}_link")[2] for name in drawers]
    assert heights == sorted(heights)
    np.testing.assert_allclose(goal.task.get_waypoints()[1].pose, goal.place_of(f"handle_{asked}"), atol=1e-9)
    assert not goal.reached()
    for other in set(drawers) - {asked}:
        goal.joint(f"chest/drawer_{other}", 0.2)
    assert not goal.reached()
    goal.border(lambda way: goal.joint(f"chest/drawer_{asked}", way), inside=0.1505, outside=0.1495)


@goal_of("open_microwave")
def test_the_microwave_has_to_open_by_eighty_degrees(goal: Goal) -> None:
    """It starts shut and stays so until it is pulled; ajar, or far enough to count as closing it, is nothing."""
    door = goal.world.joint("microwave/door")
    for _ in range(20):
        goal.world.step()
    assert door.position == pytest.approx(door.lower, abs=1e-3)
    for angle in (0.3, np.deg2rad(40.2)):
        goal.joint(door.name, angle)
        assert not goal.reached()
    goal.border(lambda angle: goal.joint(door.name, np.deg2rad(angle)), inside=80.2, outside=79.8)
    goal.joint(door.name, door.upper)
    assert goal.reached()


@goal_of("open_oven")
def test_the_oven_door_has_to_lie_flat(goal: Goal) -> None:
    """It counts from 83.4 degrees on, with an empty gripper; the knob is nothing."""
    goal.joint("oven/knob", 2.0)
    assert not goal.reached()
    goal.border(lambda angle: goal.joint("oven/door", np.deg2rad(angle)), inside=83.6, outside=83.2)
    goal.joint("oven/door", 1.57)
    goal.world.add_body("dish", BodySpec(name="dish", asset="objects/cube_small/cube_small.urdf"))
    goal.needs_release_of("dish")


# Small hinges


@goal_of("toilet_seat_down")
def test_the_toilet_seat_has_to_come_down(goal: Goal) -> None:
    """It stands by itself, and counts from 1.7 rad below where it stood; leaning it back further is nothing."""
    seat = goal.world.joint("toilet/seat_hinge")
    for _ in range(20):
        goal.world.step()
    assert seat.position == pytest.approx(1.8, abs=1e-3)
    goal.joint(seat.name, seat.upper)
    assert not goal.reached()
    goal.border(lambda angle: goal.joint(seat.name, angle), inside=0.098, outside=0.102)
    goal.joint(seat.name, 0.0)
    assert goal.reached()


@goal_of("toilet_seat_up")
def test_the_toilet_seat_has_to_go_up(goal: Goal) -> None:
    """It lies on the bowl, counts from 1.4 rad on, and stays up there by itself; let down again, it counts no more."""
    seat = goal.world.joint("toilet/seat_hinge")
    assert not goal.reached()
    goal.border(lambda angle: goal.joint(seat.name, angle), inside=1.402, outside=1.398)
    for angle in (1.402, seat.upper):
        goal.joint(seat.name, angle)
        for _ in range(20):
            goal.world.step()
        assert goal.reached()
    goal.joint(seat.name, 0.0)
    assert not goal.reached()


@goal_of("close_laptop_lid", also=["close_laptop_lid2"])
def test_the_screen_has_to_come_down(goal: Goal) -> None:
    """It stands by itself, and counts from 1.79 rad below where it stood; leaning it back further is nothing."""
    screen = goal.world.joint("laptop/screen_hinge")
    for _ in range(20):
        goal.world.step()
    assert screen.position == pytest.approx(1.9, abs=1e-3)
    goal.joint(screen.name, screen.upper)
    assert not goal.reached()
    goal.border(lambda angle: goal.joint(screen.name, angle), inside=0.108, outside=0.112)
    goal.joint(screen.name, 0.0)
    assert goal.reached()


@goal_of("open_laptop_lid")
def test_the_screen_has_to_stand_up(goal: Goal) -> None:
    """It stays where it is, 20 degrees open, and where it is left upright; it counts from 70 degrees above its start."""
    screen = goal.world.joint("laptop/screen_hinge")
    for angle, raised in ((screen.position, False), (np.deg2rad(91.0), True)):
        goal.joint(screen.name, angle)
        for _ in range(20):
            goal.world.step()
        assert screen.position == pytest.approx(angle, abs=2e-3)
        assert goal.reached() is raised
    goal.joint(screen.name, 0.0)
    assert not goal.reached()
    goal.border(lambda angle: goal.joint(screen.name, 0.35 + np.deg2rad(angle)), inside=70.2, outside=69.8)
    goal.joint(screen.name, screen.upper)
    assert goal.reached()


@goal_of("turn_oven_on")
def test_the_knob_has_to_turn_by_a_quarter(goal: Goal) -> None:
    """By 1.5 rad to either side, as specified; the door is nothing, and turned back is undone."""
    goal.joint("oven/door", 1.5)
    assert not goal.reached()
    goal.joint("oven/door", 0.0)
    for side in (1.0, -1.0):
        goal.border(lambda angle, side=side: goal.joint("oven/knob", side * angle), inside=1.505, outside=1.495)
    goal.joint("oven/knob", 0.0)
    assert not goal.reached()


@goal_of("close_box")
def test_the_lid_has_to_come_down_onto_the_walls(goal: Goal) -> None:
    """Its crease holds it where it is left; it counts from 2.6 rad below its start, not upright nor leaning over the box."""
    lid = goal.world.joint("carton/lid_hinge")
    for angle in (2.8, np.pi / 2.0, 0.45):
        goal.joint(lid.name, angle)
        for _ in range(20):
            goal.world.step()
        assert lid.position == pytest.approx(angle, abs=2e-3)
        assert not goal.reached()
    goal.joint(lid.name, lid.upper)
    assert not goal.reached()
    goal.border(lambda angle: goal.joint(lid.name, angle), inside=0.198, outside=0.202)
    goal.joint(lid.name, 0.0)
    assert goal.reached()


@goal_of("open_window")
def test_the_left_wing_has_to_swing_by_thirty_degrees(goal: Goal) -> None:
    """Turning the handle alone is not enough; the right wing is fixed."""
    assert set(goal.world.body("window").joints) == {"wing_hinge", "handle"}
    goal.joint("window/handle", 1.6)
    goal.tick()
    assert not goal.reached()
    goal.border(lambda angle: goal.joint("window/wing_hinge", np.deg2rad(angle)), inside=30.2, outside=29.8)


@goal_of("open_window")
def test_the_wing_is_held_until_the_handle_was_turned(goal: Goal) -> None:
    """79.8 degrees do not free it, 80.2 do, and a handle that is turned back does not hold it again."""
    wing = goal.world.joint("window/wing_hinge")
    for angle, held in ((79.8, True), (80.2, False), (0.0, False)):
        goal.joint("window/handle", np.deg2rad(angle))
        goal.tick()
        assert wing.locked is held
        assert not goal.reached()
    goal.joint(wing.name, 0.6)
    assert goal.reached()
