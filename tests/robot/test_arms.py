"""Every arm of the catalogue: its models agree, its fingers open and shut, and it does two tasks."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.environment import Environment
from rlbench_pin.environment.actions import Discrete, JointVelocity, MoveArmThenGripper
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.planning.kinematics import solve_ik
from rlbench_pin.robot import SUPPORTED_ROBOTS, CollisionModel, RobotModel
from rlbench_pin.robot.fingers import fingers_of
from rlbench_pin.scene import read_scene
from rlbench_pin.sim import World
from rlbench_pin.spatial import above_table
from rlbench_pin.tasks import find_task

ARMS = tuple(SUPPORTED_ROBOTS)


@pytest.mark.parametrize("name", ARMS)
def test_simulation_and_model_agree(name: str) -> None:
    """Where tip and pads are, at home and at random configurations, with the fingers half open."""
    description, rng = SUPPORTED_ROBOTS[name], np.random.default_rng(0)
    model = RobotModel(description)
    low, high = np.maximum(model.limits.lower, -3.0), np.minimum(model.limits.upper, 3.0)
    with World(read_scene(find_task("reach_target").scene_file()), description) as world:
        for q in (model.home, *rng.uniform(low, high, (20, model.size))):
            world.robot.reset_configuration(q, [0.5 * description.gripper_open] * 2)
            pose = model.tip_pose(q)
            assert np.abs(world.robot.tip_pose()[:3] - pose[:3]).max() < 1e-6
            assert abs(abs(world.robot.tip_pose()[3:] @ pose[3:]) - 1.0) < 1e-6
            assert np.allclose(world.robot.fingers, 0.5 * description.gripper_open, atol=1e-6)


@pytest.mark.parametrize("name", ARMS)
def test_finger_positions_and_joint_values_belong_together(name: str) -> None:
    """There and back; the lever is the slope."""
    description = SUPPORTED_ROBOTS[name]
    fingers = fingers_of(description)
    for share in (0.0, 0.3, 0.7, 1.0):
        positions = np.full(2, share * description.gripper_open)
        drives = fingers.drive_values(positions)
        assert np.allclose(fingers.positions(drives), positions, atol=1e-9)
        assert len(fingers.joint_values(positions)) == len(fingers.joints)
    middle = np.full(2, 0.5 * description.gripper_open)
    moved = (fingers.drive_values(middle + 1e-3) - fingers.drive_values(middle - 1e-3)) / 2e-3
    assert np.allclose(fingers.lever(middle), moved, rtol=0.02)


@pytest.mark.parametrize("name", ARMS)
def test_home_is_free_and_the_workspace_is_in_reach(name: str) -> None:
    """The hand points down at home; poses above the table are reached without a collision."""
    model = RobotModel(SUPPORTED_ROBOTS[name])
    collision, rng = CollisionModel(model), np.random.default_rng(1)
    assert not collision.in_collision(model.home)
    assert model.tip_se3(model.home).rotation[2, 2] < -0.98
    for _ in range(20):
        x, y, z = rng.uniform((0.15, -0.25, 0.1), (0.35, 0.25, 0.3))
        found = solve_ik(model, [x, y, above_table(z), 0.0, 1.0, 0.0, 0.0], model.home, rng, collision=collision)
        assert np.abs(model.tip_pose(found[0])[:3] - [x, y, above_table(z)]).max() < 1e-4


def test_whole_turns_go_the_short_way() -> None:
    """A joint that turns more than once comes from where it is; one that does not keeps its value."""
    limits = RobotModel(SUPPORTED_ROBOTS["xarm7"]).limits
    near, far = np.zeros(7), np.array([6.0, 1.0, -6.0, 1.0, 0.0, 1.0, 3.5])
    turned = limits.nearest_turn(far, near)
    assert np.allclose(turned, [6.0 - 2.0 * np.pi, 1.0, 2.0 * np.pi - 6.0, 1.0, 0.0, 1.0, 3.5 - 2.0 * np.pi])
    assert limits.contains(turned)


@pytest.mark.simulation
@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("task_name", ["reach_target", "pick_and_lift"])
def test_every_arm_demonstrates(name: str, task_name: str) -> None:
    """At the first try, with what is grasped."""
    mode = MoveArmThenGripper(JointVelocity(), Discrete())
    with Environment(mode, obs_config=low_dim_config(), robot_setup=name) as environment:
        task = environment.get_task(task_name)
        demo = task.get_demos(1, live_demos=True, seed=0, max_attempts=1)[0]
        assert demo[-1].joint_positions is not None
        assert len(demo[-1].joint_positions) == len(SUPPORTED_ROBOTS[name].arm_joints)
        assert task.world.robot.description.name == name
