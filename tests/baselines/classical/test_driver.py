"""The arm goes around what is seen, and where it is held back it waits and gives up."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

pytest.importorskip("small_gicp")

from rlbench_pin.baselines.classical.skills import DOWN, Driver, Gripper, placed, pointing
from rlbench_pin.baselines.perception import TABLE, Cloud, near
from rlbench_pin.observation import Observation
from rlbench_pin.robot import RobotModel, robot_description
from rlbench_pin.scene import WorldSnapshot
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray

PERIOD = 0.05
FINGERS = np.array([0.04, 0.04])
TURN = pointing(DOWN, np.array([0.0, 1.0, 0.0]))


def _solid(low: tuple[float, ...], high: tuple[float, ...]) -> Cloud:
    axes = [np.arange(a + 0.005, b, 0.01) for a, b in zip(low, high, strict=True)]
    points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3)
    return Cloud(points, np.zeros_like(points))


def _driver() -> Driver:
    return Driver(RobotModel(robot_description("panda")), PERIOD)


def _seen(q: FloatArray) -> Observation:
    return Observation(joint_positions=q, gripper_joint_positions=FINGERS)


def test_boxes_near_a_point_are_named_but_the_table() -> None:
    """Those of the point cloud; the table is solid for every motion."""
    points = _solid((0.3, 0.0, 0.8), (0.35, 0.05, 0.85)).points
    world = WorldSnapshot.from_point_cloud(points, np.zeros(7), FINGERS, boxes={"table": TABLE})
    assert near(world, np.array([0.3, 0.0, 0.75]), 0.06) == ["points 0"]
    assert near(world, np.array([0.3, 0.0, 0.7]), 0.06) == []


def test_motions_go_around_what_is_seen() -> None:
    """A board between start and goal is not passed through; every command keeps the velocity limits."""
    driver, rng = _driver(), np.random.default_rng(0)
    board = _solid((0.35, -0.02, TABLE_HEIGHT), (0.6, 0.02, TABLE_HEIGHT + 0.3))
    q = driver.reach(driver.arm.home, placed(TURN, np.array([0.45, 0.25, TABLE_HEIGHT + 0.15])), rng)[0]
    driver.update(board, q, FINGERS)
    goal, is_free = driver.reach(q, placed(TURN, np.array([0.45, -0.25, TABLE_HEIGHT + 0.15])), rng)
    motion, around = driver.plan(q, goal, rng)
    assert is_free and around
    tips = np.array([driver.arm.tip_se3(p).translation for p in motion.q])
    crossing = tips[np.abs(tips[:, 1]) < 0.02]
    outside = (crossing[:, 2] > TABLE_HEIGHT + 0.3) | (crossing[:, 0] < 0.35) | (crossing[:, 0] > 0.6)
    assert len(crossing) and outside.all()
    follower, v = driver.follower(motion), np.zeros(7)
    while not follower.done:
        v = follower.command(q, v)
        assert (np.abs(v) <= driver.arm.limits.velocity + 1e-9).all()
        q = q + PERIOD * v
    np.testing.assert_allclose(q, goal, atol=1e-3)


def test_what_cannot_be_planned_is_gone_to_straight() -> None:
    """A goal inside an object is reached all the same, and said not to be free."""
    driver, rng = _driver(), np.random.default_rng(0)
    target = placed(TURN, np.array([0.45, 0.0, TABLE_HEIGHT + 0.1]))
    driver.update(_solid((0.25, -0.2, TABLE_HEIGHT), (0.65, 0.2, TABLE_HEIGHT + 0.4)), driver.arm.home, FINGERS)
    goal, is_free = driver.reach(driver.arm.home, target, rng)
    assert not is_free
    motion, around = driver.plan(driver.arm.home, goal, rng)
    assert not around
    np.testing.assert_allclose(driver.arm.tip_se3(motion.q[-1]).translation, target.translation, atol=1e-4)


@pytest.mark.parametrize("held", [False, True])
def test_the_gripper_slides_straight_and_gives_up_when_it_is_held(held: bool) -> None:
    """Free, the tip stays on its line and arrives; held still, the motion is given up within a second."""
    driver = _driver()
    q = driver.arm.home.copy()
    gripper = Gripper(driver, _seen(q), np.random.default_rng(0))
    begin = gripper.tip
    end = pin.SE3(begin.rotation, begin.translation + (0.0, 0.1, -0.1))
    moves, tips = gripper.slide([end]), []
    tick = next(moves)
    for _ in range(60):
        q = q if held else q + PERIOD * tick.velocity
        tips.append(driver.arm.tip_se3(q).translation - begin.translation)
        try:
            tick = moves.send(_seen(q))
        except StopIteration:
            break
    assert len(tips) <= (20 if held else 30)
    if not held:
        np.testing.assert_allclose(tips[-1], (0.0, 0.1, -0.1), atol=0.002)
        assert max(abs(tip[0]) + abs(tip[1] + tip[2]) for tip in tips) < 0.005
