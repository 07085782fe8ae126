"""Every arm of the catalogue: its models agree, its inverse kinematics, gripper and safety filter work, and it does two tasks."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import pytest

from rlbench_pin.datasets import encode_demo
from rlbench_pin.environment import Environment
from rlbench_pin.environment.actions import Discrete, ERJointViaIK, JointVelocity, MoveArmThenGripper, SafeArm
from rlbench_pin.environment.actions.pose import PINNED_IK_TICKS, drive_until_there
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.errors import NoIkSolution
from rlbench_pin.gym import episode_steps
from rlbench_pin.planning.kinematics import solve_ik
from rlbench_pin.robot import SUPPORTED_ROBOTS, CollisionModel, RobotModel
from rlbench_pin.robot.fingers import fingers_of
from rlbench_pin.scene import read_scene
from rlbench_pin.scene.spec import BodySpec, SceneSpec
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
def test_poses_that_are_reached_are_solved(name: str) -> None:
    """995 of 1,000 poses of random configurations at least, from home."""
    model, rng = RobotModel(SUPPORTED_ROBOTS[name]), np.random.default_rng(2)
    low, high = np.maximum(model.limits.lower, -np.pi), np.minimum(model.limits.upper, np.pi)
    solved = 0
    for q in rng.uniform(low, high, (1000, model.size)):
        pose = model.tip_pose(q)
        with suppress(NoIkSolution):
            (found, *_) = solve_ik(model, pose, model.home, rng)
            solved += np.abs(model.tip_pose(found)[:3] - pose[:3]).max() < 1e-4
    assert solved >= 995


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
    """By friction alone, for two seconds: a cube of 40 mm between the fingers sinks by less than 5 mm; then it falls."""
    spec = SceneSpec(format=1, body=[BodySpec(name="cube", asset="objects/cube_small/cube_small.urdf")])
    description = SUPPORTED_ROBOTS[name]
    with World(spec, description) as world:
        cube, gripper = world.body("cube"), world.gripper
        world.robot.reset_configuration(RobotModel(description).home)
        world.dynamics_overrides.set_mass(cube.model, -1, 1.0)
        cube.graspable = True
        gripper.rely_on_friction()
        cube.set_pose(world.robot.tip_pose())
        height = cube.position[2]
        gripper.set_target(0.0)
        for _ in range(40):
            world.step()
            if not gripper.held:
                cube.set_pose(world.robot.tip_pose())
        for _ in range(40):
            world.step()
        assert gripper.held == ("cube",)
        assert cube.position[2] > height - 0.005
        gripper.set_target(1.0)
        for _ in range(20):
            world.step()
        assert cube.position[2] < height - 0.1


@pytest.mark.simulation
@pytest.mark.parametrize("name", ARMS)
def test_the_same_seed_gives_the_same_bytes(name: str) -> None:
    """In two environments."""
    demos = []
    for _ in range(2):
        with make_environment(low_dim_config(), robot=name) as environment:
            demos.append(environment.get_task("push_button").get_demos(1, live_demos=True, seed=1)[0])
    assert encode_demo(demos[0]) == encode_demo(demos[1])


@pytest.mark.simulation
@pytest.mark.parametrize("name", ARMS)
def test_random_actions_break_no_limit(name: str) -> None:
    """Through the safety filter: joint positions, velocities and accelerations stay within the limits, and nothing is touched."""
    mode, rng = MoveArmThenGripper(SafeArm(JointVelocity()), Discrete()), np.random.default_rng(3)
    with Environment(mode, obs_config=low_dim_config(), robot_setup=name) as environment:
        task = environment.get_task("open_drawer")
        task.reset(seed=0)
        robot, limits = task.world.robot, task.runtime.model.limits
        before = robot.joint_velocities
        for _ in range(300):
            task.step(np.append(rng.uniform(-1.0, 1.0, len(limits.velocity)) * limits.velocity, 1.0))
            q, v = robot.joint_positions, robot.joint_velocities
            assert limits.contains(q)
            assert (np.abs(v) <= limits.velocity + 1e-6).all()
            assert (np.abs(v - before) / task.world.control_dt <= 1.001 * np.array(robot.description.acceleration)).all()
            assert not robot.contact_forces()
            before = v


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
