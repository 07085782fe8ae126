"""The hand as programs hold it: fingers that are actuated step by step, and what it grasps."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from pyrep.objects.proximity_sensor import ProximitySensor
from pyrep.robots.arms.panda import Panda
from pyrep.robots.end_effectors.panda_gripper import PandaGripper

from pyrep.const import PrimitiveShape
from pyrep.errors import UnsupportedCall
from pyrep.objects.shape import Shape
from rlbench.backend.robot import Robot
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.environment import ObservationConfig
from rlbench_pin.tasks import task_class


@pytest.fixture
def robot() -> Iterator[Robot]:
    """Return the robot at the saucepan, hand around the knob of its lid."""
    simulator = Simulator()
    simulator.load(task_class("take_lid_off_saucepan"), ObservationConfig())
    robot = Robot(Panda(), PandaGripper())
    knob = simulator.world.frame("waypoint1").pose
    robot.arm.set_joint_positions(robot.arm.solve_ik_via_sampling(knob[:3], quaternion=knob[3:], ignore_collisions=True)[0])
    simulator.runtime.step()
    yield robot
    simulator.close()


def actuate(gripper: PandaGripper, amount: float, velocity: float) -> int:
    """Actuate and step until the fingers are done; return how many steps that took."""
    for count in range(200):
        if gripper.actuate(amount, velocity):
            return count
        Simulator.current().runtime.step()
    raise AssertionError("the fingers never stop")


def test_fingers_go_to_an_opening_at_a_speed(robot: Robot) -> None:
    """Four centimetres at 0.2 m/s are about four steps, at 0.04 m/s about twenty."""
    gripper = robot.gripper
    robot.arm.set_joint_positions(Simulator.current().model.home)
    assert gripper.get_open_amount() == pytest.approx([1.0, 1.0], abs=0.01)
    assert gripper.actuate(1.0, 0.2)
    assert 4 <= actuate(gripper, 0.0, 0.2) <= 8
    assert gripper.get_open_amount() == pytest.approx([0.0, 0.0], abs=0.02)
    assert gripper.actuate(0.0, 0.2)
    assert 18 <= actuate(gripper, 1.0, 0.04) <= 26
    actuate(gripper, 0.5, 0.2)
    assert gripper.get_joint_positions() == pytest.approx([0.02, 0.02], abs=1e-3)


def test_a_motion_that_something_else_ended_begins_again(robot: Robot) -> None:
    """An abandoned `actuate` is no reason to call a later one done."""
    robot.arm.set_joint_positions(Simulator.current().model.home)
    assert not robot.gripper.actuate(0.0, 0.2)
    robot.gripper.set_joint_positions([0.04, 0.04])
    for _ in range(5):
        Simulator.current().runtime.step()
    assert min(robot.gripper.get_open_amount()) > 0.95
    assert actuate(robot.gripper, 0.0, 0.2) > 3
    assert max(robot.gripper.get_open_amount()) < 0.02


@pytest.mark.parametrize(("amount", "velocity"), [(1.5, 0.2), (-0.1, 0.2), (0.5, 0.0), (float("nan"), 0.2)])
def test_impossible_openings_are_refused(robot: Robot, amount: float, velocity: float) -> None:
    """An opening is a share from 0 to 1, and a speed is positive."""
    with pytest.raises(ValueError, match="must be from 0 to 1"):
        robot.gripper.actuate(amount, velocity)


def test_fingers_stop_at_what_lies_between(robot: Robot) -> None:
    """Closing on the knob ends with the fingers apart and pressing."""
    actuate(robot.gripper, 0.0, 0.04)
    assert min(robot.gripper.get_open_amount()) > 0.1
    forces = np.array(robot.gripper.get_touch_sensor_forces())
    assert forces.shape == (2, 3) and np.abs(forces).sum() > 1.0


def test_grasp_takes_what_is_between_the_fingers_only(robot: Robot) -> None:
    """The lid is taken, once; the pot, which is fixed, and the table are not. What is held comes along and is let go again."""
    gripper, lid = robot.gripper, Shape("lid")
    assert not gripper.grasp(Shape("saucepan")) and not gripper.grasp(Shape("diningTable_visible"))
    actuate(gripper, 0.0, 0.04)
    assert gripper.grasp(lid) and not gripper.grasp(lid)
    assert gripper.get_grasped_objects() == [lid]
    before, tip = lid.get_position(), robot.arm.get_tip().get_pose()
    path = robot.arm.get_linear_path(tip[:3] + [0, 0, 0.15], quaternion=tip[3:], ignore_collisions=True)
    done = False
    while not done:
        done = path.step()
        Simulator.current().runtime.step()
    assert lid.get_position()[2] - before[2] == pytest.approx(0.15, abs=0.01)
    gripper.release()
    assert gripper.get_grasped_objects() == []
    actuate(gripper, 1.0, 0.2)
    for _ in range(10):
        Simulator.current().runtime.step()
    assert lid.get_position()[2] < before[2] + 0.1


def test_an_object_that_the_program_made_can_be_grasped(robot: Robot) -> None:
    """A cube between the fingers, under the name that the program gave it."""
    robot.arm.set_joint_positions(Simulator.current().model.home)
    tip = robot.arm.get_tip().get_position()
    cube = Shape.create(PrimitiveShape.CUBOID, size=[0.03, 0.03, 0.03], mass=0.05, position=tip.tolist())
    cube.set_name("my_cube")
    assert robot.gripper.grasp(cube)
    assert [held.get_name() for held in robot.gripper.get_grasped_objects()] == ["my_cube"]
    for _ in range(5):
        Simulator.current().runtime.step()
    np.testing.assert_allclose(cube.get_position(), tip, atol=2e-3)


def test_the_sensor_of_the_hand_sees_what_is_between_the_fingers(robot: Robot) -> None:
    """The lid at the knob, by the known name and by the hand's own; it moves with the hand, and never sees the arm."""
    sensor, lid = ProximitySensor("Panda_gripper_attachProxSensor"), Shape("lid")
    assert sensor == robot.gripper._proximity_sensor
    assert sensor.is_detected(lid) and sensor.read() >= 0.0 and not sensor.is_detected(Shape("saucepan"))
    robot.arm.set_joint_positions(Simulator.current().model.home)
    assert not sensor.is_detected(lid) and sensor.read() == -1.0
    np.testing.assert_allclose(sensor.get_position(), robot.arm.get_tip().get_position())


def test_far_away_nothing_is_grasped(robot: Robot) -> None:
    """With the hand at home the lid is out of reach of the fingers."""
    robot.arm.set_joint_positions(Simulator.current().model.home)
    assert not robot.gripper.grasp(Shape("lid"))


def test_an_arm_that_is_put_elsewhere_takes_along_what_it_holds(robot: Robot) -> None:
    """The lid keeps its place in the hand."""
    robot.gripper.grasp(Shape("lid"))
    tip = robot.arm.get_tip()
    before = Shape("lid").get_pose(relative_to=tip)
    robot.arm.set_joint_positions(Simulator.current().model.home)
    np.testing.assert_allclose(Shape("lid").get_pose(relative_to=tip), before, atol=1e-6)


def test_fingers_as_joints(robot: Robot) -> None:
    """Positions at once, target positions in steps, and velocities that open or close."""
    gripper, arm = robot.gripper, robot.arm
    arm.set_joint_positions(Simulator.current().model.home)
    target = arm.get_joint_target_positions()
    gripper.set_joint_positions([0.01, 0.01])
    assert gripper.get_joint_positions() == pytest.approx([0.01, 0.01])
    assert arm.get_joint_target_positions() == target
    gripper.set_joint_target_positions([0.03, 0.03])
    for _ in range(5):
        Simulator.current().runtime.step()
    assert gripper.get_joint_positions() == pytest.approx([0.03, 0.03], abs=1e-3)
    gripper.set_joint_target_velocities([-0.04, -0.04])
    for _ in range(5):
        Simulator.current().runtime.step()
    assert gripper.get_joint_positions() == pytest.approx([0.02, 0.02], abs=3e-3)
    gripper.set_joint_target_velocities([0.0, 0.0])
    assert gripper.get_joint_count() == len(gripper.joints) == 2
    assert gripper.get_joint_intervals()[1] == [[0.0, 0.04], [0.0, 0.04]]


def test_a_second_hand_is_refused(robot: Robot) -> None:
    """A world has one."""
    with pytest.raises(UnsupportedCall, match="one robot"):
        PandaGripper(1)
