"""Worlds for planning made of boxes and of points, without a simulator."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.errors import InvalidValue, PlanningError
from rlbench_pin.planning import MotionPlanner
from rlbench_pin.robot import RobotModel, robot_description
from rlbench_pin.scene import WorldSnapshot
from rlbench_pin.scene.snapshot import solid_boxes

TABLE = ((1.6, 2.0, 0.1), (0.3, 0.0, 0.70))
DOWN = [0.0, 1.0, 0.0, 0.0]


@pytest.fixture(scope="module")
def arm() -> RobotModel:
    """The Panda."""
    return RobotModel(robot_description("panda"))


def test_cubes_with_points_become_solid_and_single_points_do_not() -> None:
    """The boxes cover the points and no more space than the cubes that contain them; one point alone is noise."""
    points = np.repeat(np.array([[0.01 + 0.05 * i, 0.01, 0.01] for i in range(5)]), 2, axis=0)
    boxes = solid_boxes(np.concatenate([points, [[0.3, 0.3, 0.3]]]), cell=0.05)
    assert len(boxes) == 2
    inside = ((points[:, None] >= boxes[:, 0]) & (points[:, None] <= boxes[:, 1])).all(axis=2)
    assert inside.any(axis=1).all()
    np.testing.assert_allclose(np.prod(boxes[:, 1] - boxes[:, 0], axis=1).sum(), 5 * 0.05**3)


def test_boxes_stand_where_they_are_put() -> None:
    """A position alone means no rotation; parts of the room are known by their names, and what is held can move."""
    half = np.sqrt(0.5)
    boxes = {"table": TABLE, "block": ((0.1, 0.04, 0.04), (0.3, 0.0, 0.8, 0.0, 0.0, half, half))}
    world = WorldSnapshot.from_boxes(boxes, np.zeros(7), attached=["block"])
    table, block = world.bodies
    np.testing.assert_allclose(table.link_poses, [[0.3, 0.0, 0.70, 0.0, 0.0, 0.0, 1.0]])
    assert (table.in_room, table.fixed, block.in_room, block.fixed) == (True, True, False, False)
    np.testing.assert_allclose(block.link_poses[0, 3:], [0.0, 0.0, half, half])
    assert world.attached == ("block",)


def test_no_points_leave_the_boxes() -> None:
    """An empty cloud is a free world."""
    world = WorldSnapshot.from_point_cloud(np.zeros((0, 3)), np.zeros(7), boxes={"table": TABLE})
    assert [body.name for body in world.bodies] == ["table"]


def test_motions_keep_away_from_the_points(arm: RobotModel) -> None:
    """A board of points stands between start and goal: the straight line is refused, the planned motion goes around."""
    axes = (np.arange(0.30, 0.62, 0.005), [-0.01, 0.01], np.arange(0.75, 1.05, 0.005))
    board = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    world = WorldSnapshot.from_point_cloud(board, arm.home, boxes={"table": TABLE})
    planner = MotionPlanner(arm)
    planner.update(world)
    rng = np.random.default_rng(0)
    start = planner.plan_to_pose(arm.home, [0.4, 0.25, 0.9, *DOWN], rng=rng).path[-1]
    goal = [0.4, -0.25, 0.9, *DOWN]
    with pytest.raises(PlanningError, match="points"):
        planner.plan_to_pose(start, goal, straight=True, rng=rng)
    path = planner.plan_to_pose(start, goal, rng=rng).path
    tips = np.array([arm.tip_pose(q)[:3] for q in path])
    assert not ((tips[:, 0] > 0.3) & (tips[:, 0] < 0.62) & (np.abs(tips[:, 1]) < 0.01) & (tips[:, 2] < 1.05)).any()


@pytest.mark.parametrize(
    ("boxes", "attached", "message"),
    [
        ({"block": ((0.1, 0.0, 0.1), (0, 0, 0))}, (), "the sides of the box 'block'"),
        ({"block": ((0.1, 0.1, 0.1), (0, 0))}, (), "the pose of the box 'block'"),
        ({"block": ((0.1, np.nan, 0.1), (0, 0, 0))}, (), "the sides of the box 'block'"),
        ({"block": ((0.1, 0.1, 0.1), (0, 0, 0))}, ("blok",), "block"),
    ],
)
def test_wrong_boxes_are_refused(boxes: dict[str, object], attached: tuple[str, ...], message: str) -> None:
    """The message names the box."""
    with pytest.raises(InvalidValue, match=message):
        WorldSnapshot.from_boxes(boxes, np.zeros(7), attached=attached)  # type: ignore[arg-type]
