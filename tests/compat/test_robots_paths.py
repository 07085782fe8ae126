"""Paths of the arm: planned over the present world, stepped by the program, at their goal when they are done."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from pyrep.const import ConfigurationPathAlgorithms as Algos
from pyrep.errors import ConfigurationPathError
from pyrep.objects.cartesian_path import CartesianPath
from pyrep.objects.shape import Shape
from pyrep.robots.arms.panda import Panda
from pyrep.robots.configuration_paths.arm_configuration_path import ArmConfigurationPath
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.environment import ObservationConfig
from rlbench_pin.tasks import task_class

DOWN = [0.0, 1.0, 0.0, 0.0]


@pytest.fixture
def arm() -> Iterator[Panda]:
    """Return the arm over an empty table."""
    simulator = Simulator()
    yield Panda()
    simulator.close()


def follow(path: ArmConfigurationPath) -> int:
    """Step a path and the world in turn; return how often."""
    for count in range(1, 1000):
        done = path.step()
        Simulator.current().runtime.step()
        if done:
            return count
    raise AssertionError("the path has no end")


@pytest.mark.parametrize("ignore_collisions", [False, True])
def test_a_path_that_is_followed_ends_at_its_goal(arm: Panda, ignore_collisions: bool) -> None:
    """Within a millimetre, at rest, after as many steps as the motion is long."""
    goal = [0.4, 0.25, 0.95]
    path = arm.get_path(goal, quaternion=DOWN, ignore_collisions=ignore_collisions, trials=100, algorithm=Algos.RRTConnect)
    assert path.get_executed_joint_position_action() is None
    count = follow(path)
    assert 20 < count < 100
    np.testing.assert_allclose(arm.get_tip().get_position(), goal, atol=1e-3)
    assert np.abs(arm.get_joint_velocities()).max() < 0.05
    np.testing.assert_allclose(path.get_executed_joint_position_action(), path[-1], atol=1e-9)
    with pytest.raises(RuntimeError, match="set_to_start"):
        path.step()


def test_a_path_can_be_followed_again(arm: Panda) -> None:
    """From its start, to which the arm is put back."""
    path = arm.get_path([0.4, -0.2, 1.1], quaternion=DOWN)
    first = follow(path)
    path.set_to_start()
    np.testing.assert_allclose(arm.get_joint_positions(), path[0])
    assert follow(path) == first
    path.set_to_start(disable_dynamics=True)
    path.set_to_end()
    np.testing.assert_allclose(arm.get_tip().get_position(), [0.4, -0.2, 1.1], atol=1e-4)


def test_points_of_a_path(arm: Panda) -> None:
    """Flat numbers that make configurations, from where the arm is to the goal."""
    path = arm.get_path([0.4, 0.2, 1.0], quaternion=DOWN)
    points = path._path_points.reshape(-1, 7)
    assert len(path) == len(points) > 3
    np.testing.assert_allclose(path[0], arm.get_joint_positions(), atol=1e-6)
    np.testing.assert_allclose(list(path), points)
    np.testing.assert_allclose(path[1:3], points[1:3])
    path.visualize()
    path.clear_visualization()


def test_a_linear_path_keeps_the_tip_on_a_line(arm: Panda) -> None:
    """Every configuration of it has the tip between start and goal."""
    start = arm.get_tip().get_position()
    goal = start + np.array([0.05, 0.1, -0.2])
    path = arm.get_linear_path(goal, quaternion=arm.get_tip().get_quaternion(), steps=50)
    axis = (goal - start) / np.linalg.norm(goal - start)
    tips = np.array([Simulator.current().model.tip_pose(q)[:3] for q in path]) - start
    assert np.linalg.norm(tips - np.outer(tips @ axis, axis), axis=1).max() < 1e-3
    other = arm.get_nonlinear_path(goal, quaternion=arm.get_tip().get_quaternion(), algorithm=Algos.RRT)
    follow(other)
    np.testing.assert_allclose(arm.get_tip().get_position(), goal, atol=1e-3)


def test_paths_that_cannot_be_raise(arm: Panda) -> None:
    """Out of reach, and into the table unless collisions are ignored."""
    with pytest.raises(ConfigurationPathError, match="cannot reach"):
        arm.get_path([5, 0, 1], quaternion=DOWN)
    with pytest.raises(ConfigurationPathError, match="table"):
        arm.get_path([0.3, 0, 0.75], quaternion=DOWN)
    with pytest.raises(ConfigurationPathError):
        arm.get_linear_path([-0.6, 0, 1.0], quaternion=DOWN)
    arm.get_path([0.3, 0, 0.75], quaternion=DOWN, ignore_collisions=True)


def test_a_goal_in_the_frame_of_another_object(arm: Panda) -> None:
    """Ten centimetres ahead of the tip, along its own axis."""
    tip = arm.get_tip()
    ahead = tip.get_position() + 0.1 * tip.get_matrix()[:3, 2]
    follow(arm.get_path([0, 0, 0.1], euler=[0, 0, 0], relative_to=tip))
    np.testing.assert_allclose(tip.get_position(), ahead, atol=1e-3)


def test_the_pace_of_the_arm_is_the_pace_of_its_paths(arm: Panda) -> None:
    """At half the speed a motion takes longer, and a soft jerk limit makes it longer still."""
    goal = {"position": [0.4, 0.3, 1.0], "quaternion": DOWN}
    usual = follow(arm.get_path(**goal))
    arm.set_joint_positions(Simulator.current().model.home)
    slow = Panda(max_velocity=0.5, max_acceleration=2.0)
    path = slow.get_path(**goal)
    speeds = []
    done = False
    while not done:
        done = path.step()
        Simulator.current().runtime.step()
        speeds.append(np.abs(slow.get_joint_velocities()).max())
    assert len(speeds) > 1.5 * usual
    assert max(speeds) < 0.55
    arm.set_joint_positions(Simulator.current().model.home)
    arm.max_jerk = 10.0
    assert follow(arm.get_path(**goal)) > usual + 4


def test_a_path_of_ones_own_points(arm: Panda) -> None:
    """Configurations that a program made are timed and followed like planned ones; replaced points are timed again."""
    q = np.array(arm.get_joint_positions())
    points = np.concatenate([q, q + 0.1, q + 0.3])
    path = ArmConfigurationPath(arm, points)
    follow(path)
    np.testing.assert_allclose(arm.get_joint_positions(), q + 0.3, atol=2e-3)
    path.set_to_start()
    path._path_points = np.concatenate([q, q - 0.2])
    follow(path)
    np.testing.assert_allclose(arm.get_joint_positions(), q - 0.2, atol=2e-3)
    with pytest.raises(ValueError, match="7 numbers per configuration"):
        ArmConfigurationPath(arm, [0.0] * 8)


def test_a_cartesian_path_is_followed(arm: Panda) -> None:
    """The tip passes all control points and ends at the last."""
    x, y, z = arm.get_tip().get_position()
    down = arm.get_tip().get_orientation()
    line = CartesianPath.create()
    line.insert_control_points([[x, y, z - 0.1, *down], [x, y + 0.1, z - 0.15, *down], [x + 0.05, y + 0.15, z - 0.1, *down]])
    last, _ = line.get_pose_on_path(1.0)
    follow(arm.get_path_from_cartesian_path(line))
    np.testing.assert_allclose(arm.get_tip().get_position(), last, atol=1e-3)


def test_what_is_not_collidable_is_not_planned_around(arm: Panda) -> None:
    """A goal inside the saucepan is refused, and allowed once its parts are made not collidable."""
    Simulator.current().load(task_class("take_lid_off_saucepan"), ObservationConfig())
    lid = Simulator.current().world.body("lid")
    inside = [*lid.position[:2], lid.position[2] - 0.05]
    with pytest.raises(ConfigurationPathError):
        arm.get_path(inside, quaternion=DOWN)
    for name in Simulator.current().world.bodies:
        Shape(name).set_collidable(False)
    arm.get_path(inside, quaternion=DOWN)
