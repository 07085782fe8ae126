"""The arm follows commands in three modes and reports what it measures."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.errors import InvalidActionError
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.spec import SceneSpec
from rlbench_pin.spatial import rotation_distance
from tests.sim.support import ABOVE, HOME, PANDA, build, move, steps

SIGNS = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0])


@pytest.fixture
def world():
    """A world without objects."""
    with build(SceneSpec(format=1)) as world:
        yield world


def test_tracks_a_motion_of_one_radian_per_second(world):
    """The lag behind a 1 rad/s motion stays below 1 mrad, and the speed is that of the command."""
    lags, errors, previous = [], [], HOME
    for k in range(1, 60):
        target = np.clip(HOME + SIGNS * 0.4 * (1 - np.cos(k * 0.05 / 0.4)), world.robot.lower, world.robot.upper)
        world.robot.set_position_targets(target)
        world.step()
        lags.append(np.abs(world.robot.joint_positions - target).max())
        errors.append(np.abs(world.robot.joint_velocities - (target - previous) / 0.05).max())
        previous = target
    assert max(lags) < 2e-4
    assert max(errors) < 0.02


def test_a_held_posture_rests(world):
    """Held at home the arm neither moves nor sags, and the motors carry the gravity that Pinocchio predicts."""
    steps(world, 20)
    assert np.abs(world.robot.joint_velocities).max() < 1e-6
    assert np.abs(world.robot.joint_positions - HOME).max() < 1e-4
    np.testing.assert_allclose(world.robot.joint_torques, RobotModel(PANDA).gravity(HOME), atol=0.05)


def test_a_wild_jump_keeps_the_velocity_limits(world):
    """A target far away is approached at no more than 110 % of the velocity limits, and reached."""
    target = HOME + np.array([1.0, 0.5, 0.0, 0.0, 0.0, 0.0, -1.0])
    world.robot.set_position_targets(target)
    speeds = []
    for _ in range(20):
        world.step()
        speeds.append(np.abs(world.robot.joint_velocities) / world.robot.velocity_limits)
    assert np.max(speeds) < 1.11
    assert np.abs(world.robot.joint_positions - target).max() < 1e-3


def test_a_blocked_arm_presses_without_trembling(world):
    """Pressed into the table the arm rests, with its torques at most at the effort limits, and comes back in order."""
    down = HOME + np.array([0.0, 1.225, 0.0, -0.33, 0.0, 0.0, 0.0])
    move(world, down)
    steps(world, 40)
    assert world.robot.touching() == ("table",)
    assert np.abs(world.robot.joint_velocities).max() < 1e-3
    assert (np.abs(world.robot.joint_torques) <= world.robot.effort_limits + 1e-9).all()
    world.robot.set_position_targets(HOME)
    for _ in range(40):
        world.step()
        assert (np.abs(world.robot.joint_velocities) < 1.11 * world.robot.velocity_limits).all()
    assert np.abs(world.robot.joint_positions - HOME).max() < 1e-3


@pytest.mark.simulation
def test_velocity_mode(world):
    """A velocity persists until it is changed, moves the arm accordingly, and stops at joint limits."""
    world.robot.set_velocity_targets(np.full(7, 0.2))
    steps(world, 10)
    np.testing.assert_allclose(world.robot.joint_positions - HOME, 0.1, atol=2e-3)
    steps(world, 400)
    assert (world.robot.joint_positions <= world.robot.upper + 1e-3).all()
    world.robot.set_velocity_targets(np.zeros(7))
    steps(world, 2)
    assert np.abs(world.robot.joint_velocities).max() < 0.01


def test_torque_mode_is_the_dynamics_of_the_model(world):
    """Gravity torques keep the arm where it is; other torques turn the joints as Pinocchio says."""
    model = RobotModel(PANDA)
    for _ in range(10):
        world.robot.set_torques(model.gravity(world.robot.joint_positions))
        world.step()
    assert np.abs(world.robot.joint_velocities).max() < 1e-4
    tau = model.gravity(HOME) + np.array([2.0, -1.0, 1.0, 1.0, 0.1, -0.1, 0.1])
    world.robot.reset_configuration(HOME)
    world.robot.set_torques(tau)
    world.step()
    q, v = HOME.copy(), np.zeros(7)
    for _ in range(12):
        v += model.forward_dynamics(q, v, tau - 0.003 * v) / 240.0
        q += v / 240.0
    np.testing.assert_allclose(world.robot.joint_velocities, v, atol=0.02 * np.abs(v).max())
    np.testing.assert_array_equal(world.robot.joint_torques, tau)


def test_modes_can_be_changed_at_any_time(world):
    """From torque and velocity back to position the arm holds where it is told."""
    world.robot.set_torques(np.zeros(7))
    steps(world, 3)
    world.robot.set_velocity_targets(np.zeros(7))
    steps(world, 2)
    here = world.robot.joint_positions
    world.robot.set_position_targets(here)
    steps(world, 5)
    np.testing.assert_allclose(world.robot.joint_positions, here, atol=1e-3)


def test_pinocchio_and_the_simulation_agree_on_the_tip(world):
    """Forward kinematics of the model and of the simulation give the same tip."""
    model = RobotModel(PANDA)
    for q in (HOME, ABOVE):
        world.robot.reset_configuration(q)
        pose = world.robot.tip_pose()
        np.testing.assert_allclose(pose[:3], model.tip_pose(q)[:3], atol=1e-6)
        assert rotation_distance(pose, model.tip_pose(q)) < 1e-6
        np.testing.assert_allclose(world.robot.link_poses()[PANDA.tip_frame], pose)


@pytest.mark.parametrize("command", ["set_position_targets", "set_velocity_targets", "set_torques"])
@pytest.mark.parametrize("value", [np.zeros(6), np.full(7, np.nan), np.full(7, np.inf), np.zeros((1, 7))])
def test_a_bad_command_is_refused_and_changes_nothing(world, command, value):
    """A wrong shape, NaN or infinity raises InvalidActionError; the arm goes on as before."""
    before = world.robot.control
    with pytest.raises(InvalidActionError):
        getattr(world.robot, command)(value)
    assert world.robot.control is before


def test_returned_arrays_are_the_callers(world):
    """Writing into a returned array does not change the robot."""
    q = world.robot.joint_positions
    q[:] = 0.0
    np.testing.assert_allclose(world.robot.joint_positions, HOME)
