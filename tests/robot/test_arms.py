"""Every arm of the catalogue: its models agree, its inverse kinematics, gripper and safety filter work, and it does two tasks."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.checking import arms
from rlbench_pin.environment import Environment
from rlbench_pin.environment.actions import Discrete, ERJointViaIK, MoveArmThenGripper
from rlbench_pin.environment.actions.pose import PINNED_IK_TICKS, drive_until_there
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.gym import episode_steps
from rlbench_pin.robot import SUPPORTED_ROBOTS, CollisionModel, RobotModel
from rlbench_pin.robot.fingers import fingers_of
from rlbench_pin.scene.spec import SceneSpec
from rlbench_pin.sim import World

ARMS = tuple(SUPPORTED_ROBOTS)


@pytest.mark.parametrize("name", ARMS)
def test_simulation_and_model_agree(name: str) -> None:
    """Where tip and pads are, at home and at random configurations, with the fingers half open."""
    description = SUPPORTED_ROBOTS[name]
    model = RobotModel(description)
    configurations = np.array([model.home, *arms.random_configurations(model, 20, turn=3.0)])
    far, turned = arms.tip_deviation(model, configurations, opening=0.5)
    assert far < 1e-6
    assert turned < 1e-6
    with World(SceneSpec(format=1), description) as world:
        for q in configurations:
            world.robot.reset_configuration(q, [0.5 * description.gripper_open] * 2)
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
    assert not CollisionModel(model).in_collision(model.home)
    assert model.tip_se3(model.home).rotation[2, 2] < -0.98
    assert arms.reached_places(model, 20) == 20


def test_whole_turns_go_the_short_way() -> None:
    """A joint that turns more than once comes from where it is; one that does not keeps its value."""
    limits = RobotModel(SUPPORTED_ROBOTS["xarm7"]).limits
    near, far = np.zeros(7), np.array([6.0, 1.0, -6.0, 1.0, 0.0, 1.0, 3.5])
    turned = limits.nearest_turn(far, near)
    assert np.allclose(turned, [6.0 - 2.0 * np.pi, 1.0, 2.0 * np.pi - 6.0, 1.0, 0.0, 1.0, 3.5 - 2.0 * np.pi])
    assert limits.contains(turned)


@pytest.mark.simulation
@pytest.mark.parametrize("name", ARMS)
def test_poses_that_are_reached_are_solved(name: str) -> None:
    """995 of 1,000 poses of random configurations at least, from home."""
    assert arms.solved_poses(RobotModel(SUPPORTED_ROBOTS[name]), 1000) >= 995


def test_slow_arms_have_more_time() -> None:
    """The factor is 1 for the Panda and for arms that are faster, and what a joint of the Jaco is slower."""
    found = {name: RobotModel(description).slowness for name, description in SUPPORTED_ROBOTS.items()}
    assert found["panda"] == found["ur5e"] == found["xarm7"] == 1.0
    assert found["iiwa"] == pytest.approx(2.175 / 1.71, abs=0.01)
    assert found["jaco"] == pytest.approx(2.175 / 0.628, abs=0.01)
    assert [episode_steps(name) for name in ("panda", "jaco")] == [1000, 3462]


@pytest.mark.simulation
def test_a_slow_arm_gets_where_its_pinned_joint_is_sent() -> None:
    """The Jaco turns its base by 2 rad, in more than the 50 ticks that the Panda has."""
    mode = MoveArmThenGripper(ERJointViaIK(commanded_joints=(0,)), Discrete())
    with Environment(mode, obs_config=low_dim_config(), robot_setup="jaco", seed=0) as environment:
        task = environment.get_task("reach_target")
        task.reset(seed=0)
        runtime = task.runtime
        goal = runtime.model.home + np.array([2.0, 0.0, 0.0, 0.0, 0.0, 0.0])
        began = task.world.ticks
        drive_until_there(runtime, goal, 1e-3, PINNED_IK_TICKS)
        assert PINNED_IK_TICKS < task.world.ticks - began < 3.5 * PINNED_IK_TICKS
        np.testing.assert_allclose(runtime.robot.joint_positions, goal, atol=0.01)


@pytest.mark.simulation
@pytest.mark.parametrize("name", ARMS)
def test_the_gripper_holds_a_kilogram(name: str) -> None:
    """By friction alone, for two seconds: a cube of 40 mm sinks by less than 5 mm; then it falls. Pads stay outside it."""
    grip = arms.grip_of(SUPPORTED_ROBOTS[name])
    assert grip.opened > 0.95 * SUPPORTED_ROBOTS[name].gripper_open
    assert grip.shut < 0.002
    assert grip.depth < 0.002
    assert grip.held
    assert grip.sunk < 0.005
    assert grip.falls


@pytest.mark.simulation
@pytest.mark.parametrize("name", ARMS)
def test_the_same_seed_gives_the_same_bytes(name: str) -> None:
    """In two environments."""
    first, second = (arms.encoded_demo(SUPPORTED_ROBOTS[name], "push_button", seed=1) for _ in range(2))
    assert first == second


@pytest.mark.simulation
@pytest.mark.parametrize("name", ARMS)
def test_random_actions_break_no_limit(name: str) -> None:
    """Through the safety filter: joint positions, velocities and accelerations stay within the limits, and nothing is touched."""
    faults, _ = arms.broken_limits(SUPPORTED_ROBOTS[name], 300, "open_drawer")
    assert faults == []


@pytest.mark.simulation
@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("task_name", ["reach_target", "pick_and_lift"])
def test_every_arm_demonstrates(name: str, task_name: str) -> None:
    """At the first try, with what is grasped."""
    demo = arms.demonstration(SUPPORTED_ROBOTS[name], task_name)
    assert demo[-1].joint_positions is not None
    assert len(demo[-1].joint_positions) == len(SUPPORTED_ROBOTS[name].arm_joints)
    assert demo.robot == name


@pytest.mark.simulation
@pytest.mark.parametrize("name", ARMS)
def test_the_wrist_camera_sees_the_table(name: str) -> None:
    """At home, in most of its image; arm and fingers hide the rest."""
    assert arms.free_share(SUPPORTED_ROBOTS[name]) > 0.5
