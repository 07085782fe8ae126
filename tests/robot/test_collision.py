"""Collision checks of the arm in small worlds."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.errors import StartInCollision
from rlbench_pin.robot.collision import CollisionModel
from rlbench_pin.robot.model import RobotModel
from tests.worlds_for_tests import HOME, Boxes

PALM = 0.1034
"""Distance from the hand's frame to the tip [m]."""


@pytest.fixture
def collision(model: RobotModel) -> CollisionModel:
    """A collision model of the arm in an empty world."""
    return CollisionModel(model)


@pytest.fixture
def tip(model: RobotModel) -> np.ndarray:
    """Where the tip is at home (3,)."""
    return model.tip_pose(HOME)[:3]


def random_configurations(model: RobotModel, count: int) -> np.ndarray:
    """Configurations anywhere within the limits."""
    return np.random.default_rng(3).uniform(model.limits.lower, model.limits.upper, (count, model.size))


def test_the_arm_alone_collides_with_itself_only_when_folded(collision: CollisionModel) -> None:
    """Home is free; a folded elbow presses the hand into the arm."""
    assert not collision.in_collision(HOME)
    folded = np.array([0.0, -1.7, 0.0, -3.07, 0.0, 0.0, 0.0])
    assert collision.in_collision(folded)
    assert all(a.startswith("panda") and b.startswith("panda") for a, b in collision.colliding_pairs(folded))


def test_the_base_may_stand_on_the_table(collision: CollisionModel, boxes: Boxes) -> None:
    """The table below the base does not count, but the hand in the table does."""
    collision.update(boxes.snapshot())
    assert not collision.in_collision(HOME)
    down = HOME + np.array([0.0, 0.9, 0.0, -0.9, 0.0, 0.0, 0.0])
    assert "table" in {b for _, b in collision.colliding_pairs(down)}


def test_a_box_at_the_fingers_is_found(collision: CollisionModel, boxes: Boxes, tip: np.ndarray) -> None:
    """The names of what touches what are reported."""
    collision.update(boxes.snapshot(boxes.box("rock", (0.2, 0.2, 0.05), tip)))
    assert collision.in_collision(HOME)
    assert ("panda_leftfinger", "rock") in collision.colliding_pairs(HOME)


def test_boxes_move_with_the_snapshot(collision: CollisionModel, boxes: Boxes, tip: np.ndarray) -> None:
    """A second snapshot of the same bodies renews their places, and bodies that do not collide are left out."""
    size = (0.2, 0.2, 0.05)
    collision.update(boxes.snapshot(boxes.box("rock", size, tip)))
    collision.update(boxes.snapshot(boxes.box("rock", size, tip - [0.0, 0.0, 0.3])))
    assert not collision.in_collision(HOME)
    collision.update(boxes.snapshot(boxes.box("rock", size, tip)))
    assert collision.in_collision(HOME)
    collision.update(boxes.snapshot(boxes.box("rock", size, tip, collides=False)))
    assert not collision.in_collision(HOME)


def test_finger_positions_count(collision: CollisionModel, boxes: Boxes, model: RobotModel) -> None:
    """A bar between open fingers touches nothing; closed fingers meet it."""
    bar = boxes.box("bar", (0.02, 0.02, 0.02), model.tip_pose(HOME)[:3])
    collision.update(boxes.snapshot(bar, opening=0.04))
    assert not collision.in_collision(HOME)
    collision.update(boxes.snapshot(bar, opening=0.0))
    assert collision.in_collision(HOME)


def test_fast_and_slow_answers_agree(collision: CollisionModel, boxes: Boxes, model: RobotModel) -> None:
    """The broad phase finds exactly the collisions of all pairs, with and without clearance."""
    collision.update(boxes.snapshot(*boxes.cubes(12), boxes.screen()))
    for margin in (0.0, 0.003, 0.05):
        collision.begin(HOME, margin=margin)
        for q in random_configurations(model, 300):
            assert collision.in_collision(q) == bool(collision.colliding_pairs(q))


def test_margin_is_a_distance(collision: CollisionModel, boxes: Boxes, model: RobotModel) -> None:
    """With clearance, collisions are exactly the configurations nearer to the world than that."""
    collision.update(boxes.snapshot(boxes.screen()))
    collision.begin(HOME, margin=0.04)
    for q in random_configurations(model, 150):
        near = any(d.distance <= (0.04 if d.b in ("table", "screen") else 0.0) for d in collision.distances(q, 0.05))
        assert collision.in_collision(q) == near


def test_distance_names_the_nearest_pair(collision: CollisionModel, boxes: Boxes, tip: np.ndarray) -> None:
    """Distance, points and normal fit together."""
    collision.update(boxes.snapshot(boxes.box("rock", (0.1, 0.1, 0.1), tip - [0.0, 0.0, 0.1])))
    nearest = collision.distance(HOME)
    assert nearest is not None
    assert nearest.b == "rock"
    assert np.linalg.norm(nearest.point_b - nearest.point_a) == pytest.approx(nearest.distance, abs=1e-4)
    np.testing.assert_allclose(nearest.point_a + nearest.distance * nearest.normal, nearest.point_b, atol=1e-4)


def test_allowed_objects_may_be_touched_but_not_the_room(collision: CollisionModel, boxes: Boxes, tip: np.ndarray) -> None:
    """`allowed` takes an object out of one motion; the room stays solid."""
    collision.update(boxes.snapshot(boxes.box("rock", (0.2, 0.2, 0.05), tip - [0.0, 0.0, 0.1])))
    lower = HOME + np.array([0.0, 0.2, 0.0, 0.0, 0.0, 0.0, 0.0])
    collision.begin(HOME, allowed=("rock", "table"))
    assert not collision.in_collision(lower)
    assert collision.in_collision(HOME + np.array([0.0, 0.9, 0.0, -0.9, 0.0, 0.0, 0.0]))
    collision.begin(HOME)
    assert collision.in_collision(lower)


def test_what_touches_the_hand_at_the_start_may_be_touched(collision: CollisionModel, boxes: Boxes, tip: np.ndarray) -> None:
    """An object at the fingers does not block the hand, but it still blocks the arm."""
    rock = boxes.box("rock", (0.2, 0.2, 0.05), tip)
    collision.update(boxes.snapshot(rock))
    collision.begin(HOME, margin=0.003)
    assert not collision.in_collision(HOME)
    assert all(d.a.startswith("panda_link") for d in collision.distances(HOME) if d.b == "rock")


def test_near_things_may_stay_near(collision: CollisionModel, boxes: Boxes, model: RobotModel) -> None:
    """A start nearer than the margin is accepted, but going nearer is not."""
    free = CollisionModel(model)
    free.update(boxes.snapshot())
    gap = free.distances(HOME)
    assert gap
    ground = 0.0
    for height in np.arange(1.3, 1.5, 0.0005):
        free.update(boxes.snapshot(boxes.box("rock", (0.5, 0.5, 0.01), (0.3, 0.0, height))))
        if free.in_collision(HOME):
            break
        ground = height
    collision.update(boxes.snapshot(boxes.box("rock", (0.5, 0.5, 0.01), (0.3, 0.0, ground - 0.001))))
    collision.begin(HOME, margin=0.01)
    assert not collision.in_collision(HOME)
    assert collision.in_collision(HOME + np.array([0.0, 0.02, 0.0, 0.0, 0.0, 0.0, 0.0]))


def test_a_start_deep_in_the_table_is_refused(collision: CollisionModel, boxes: Boxes) -> None:
    """The error names the pair."""
    collision.update(boxes.snapshot())
    deep = HOME + np.array([0.0, 0.9, 0.0, -0.9, 0.0, 0.0, 0.0])
    with pytest.raises(StartInCollision, match="with table") as caught:
        collision.begin(deep)
    assert all(b == "table" for _, b in caught.value.pairs)


@pytest.mark.parametrize("in_room", [True, False])
def test_only_the_snapshot_says_what_the_room_is(
    collision: CollisionModel, boxes: Boxes, model: RobotModel, tip: np.ndarray, in_room: bool
) -> None:
    """A body called `wall` may be touched when that is allowed, unless it belongs to the room."""
    collision.update(boxes.snapshot(boxes.box("wall", (0.2, 0.2, 0.05), tip, in_room=in_room)))
    assert collision.in_collision(HOME)
    collision.allow(("wall",))
    assert collision.in_collision(HOME) == in_room


def test_a_held_body_is_carried_along(collision: CollisionModel, boxes: Boxes, model: RobotModel, tip: np.ndarray) -> None:
    """What the hand holds collides with the world where the hand carries it, and not with the hand."""
    stick = boxes.box("stick", (0.02, 0.02, 0.3), tip - [0.0, 0.0, 0.1])
    post = boxes.box("post", (0.1, 0.1, 0.05), tip + [0.0, 0.3, -0.2])
    turned = HOME + np.array([0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    where = model.tip_pose(turned)[:3]
    post = boxes.box("post", (0.1, 0.1, 0.05), where - [0.0, 0.0, 0.2])
    collision.update(boxes.snapshot(stick, post, attached=("stick",)))
    assert not collision.in_collision(HOME)
    assert collision.colliding_pairs(turned) in ([("post", "stick")], [("stick", "post")])
    collision.update(boxes.snapshot(post))
    assert not collision.in_collision(turned)


def test_a_held_body_may_leave_what_it_stands_on(collision: CollisionModel, boxes: Boxes, model: RobotModel) -> None:
    """A grasped cube on a stand may start and lift off, but not be pushed into the stand."""
    tip = model.tip_pose(HOME)[:3]
    cube = boxes.box("cube", (0.05, 0.05, 0.05), tip)
    stand = boxes.box("stand", (0.04, 0.04, 0.2), tip - [0.0, 0.0, 0.125])
    collision.update(boxes.snapshot(cube, stand, attached=("cube",), opening=0.025))
    collision.begin(HOME, margin=0.003, allowed=("cube",))
    assert not collision.in_collision(HOME)
    assert not collision.in_collision(HOME - np.array([0.0, 0.05, 0.0, 0.0, 0.0, 0.0, 0.0]))
    assert collision.in_collision(HOME + np.array([0.0, 0.05, 0.0, 0.0, 0.0, 0.0, 0.0]))


def test_a_held_body_that_is_fixed_is_left_out(collision: CollisionModel, boxes: Boxes, tip: np.ndarray) -> None:
    """The handle of something fixed to the world does not move with the hand."""
    chest = boxes.box("chest", (0.4, 0.4, 0.3), tip, fixed=True)
    collision.update(boxes.snapshot(chest, attached=("chest",)))
    assert not collision.in_collision(HOME)


def test_a_goal_may_be_near_things(collision: CollisionModel, boxes: Boxes, model: RobotModel, tip: np.ndarray) -> None:
    """Clearance is not asked of goals, and the way there may then be as near as the goal."""
    collision.update(boxes.snapshot(boxes.box("plate", (0.5, 0.5, 0.01), (0.3, 0.0, 1.2))))
    collision.begin(HOME, margin=0.5)
    goal = HOME + np.array([0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    assert collision.in_collision(goal)
    assert not collision.goal_in_collision(goal)
    collision.relax(goal)
    assert not collision.in_collision(goal)


def test_distances_do_not_depend_on_what_was_asked_before(collision: CollisionModel, boxes: Boxes, model: RobotModel) -> None:
    """To the last bit, so that a motion that is planned again is the same."""
    collision.update(boxes.snapshot(boxes.screen(), *boxes.cubes(4)))
    first = [d.distance for d in collision.distances(HOME)]
    for q in np.random.default_rng(0).uniform(model.limits.lower, model.limits.upper, (30, 7)):
        collision.distances(q)
    assert [d.distance for d in collision.distances(HOME)] == first
