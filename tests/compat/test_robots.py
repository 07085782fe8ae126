"""The arm as programs hold it: joints, motors, kinematics and collisions of the running world, and the gripper."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from pyrep.const import PrimitiveShape
from pyrep.errors import ConfigurationError, ConfigurationPathError, IKError, UnsupportedCall
from pyrep.objects.dummy import Dummy
from pyrep.objects.proximity_sensor import ProximitySensor
from pyrep.objects.shape import Shape
from pyrep.robots.arms.jaco import Jaco
from pyrep.robots.arms.panda import Panda
from pyrep.robots.arms.ur5 import UR5
from pyrep.robots.end_effectors.panda_gripper import PandaGripper
from pyrep.robots.end_effectors.robotiq85_gripper import Robotiq85Gripper
from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import JointVelocity
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.backend.robot import Robot
from rlbench.const import SUPPORTED_ROBOTS, colors
from rlbench.environment import Environment
from rlbench.tasks import ReachTarget
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.environment import ObservationConfig
from rlbench_pin.robot import UnknownRobot
from rlbench_pin.tasks import task_class

DOWN = [0.0, 1.0, 0.0, 0.0]


@pytest.fixture
def simulator() -> Iterator[Simulator]:
    """Return a simulator with an empty table."""
    simulator = Simulator()
    yield simulator
    simulator.close()


@pytest.fixture
def arm(simulator: Simulator) -> Panda:
    """Return the arm of that simulator."""
    return Panda()


def steps(count: int) -> None:
    """Step the world."""
    for _ in range(count):
        Simulator.current().runtime.step()


def test_an_arm_knows_its_joints_limits_and_tip(arm: Panda) -> None:
    """Seven joints with the limits of the model, and a tip where kinematics says it is."""
    runtime = Simulator.current().runtime
    assert arm.get_joint_count() == len(arm.joints) == 7
    assert arm.joints[2].get_name() == "Panda_joint3"
    cyclic, intervals = arm.get_joint_intervals()
    assert cyclic == [False] * 7
    np.testing.assert_allclose(np.sum(intervals, axis=1), runtime.model.limits.upper, atol=1e-9)
    np.testing.assert_allclose(arm.get_joint_upper_velocity_limits(), runtime.model.limits.velocity)
    assert isinstance(arm.get_tip(), Dummy)
    np.testing.assert_allclose(arm.get_tip().get_pose(), runtime.model.tip_pose(np.array(arm.get_joint_positions())), atol=1e-6)
    assert isinstance(arm.get_joint_positions() + [1.0], list)


def test_joints_of_the_arm_are_the_arms_own(arm: Panda) -> None:
    """What the arm says of a joint and what the joint says of itself agree."""
    arm.set_joint_positions([0.1, 0.2, -0.1, -1.0, 0.3, 1.3, 0.5])
    np.testing.assert_allclose([joint.get_joint_position() for joint in arm.joints], arm.get_joint_positions())


def test_joint_positions_are_set_at_once_and_kept(arm: Panda) -> None:
    """A configuration is taken without moving there, and held."""
    q = [0.3, 0.4, 0.0, -1.2, 0.0, 1.5, 0.5]
    arm.set_joint_positions(q, disable_dynamics=True)
    np.testing.assert_allclose(arm.get_joint_positions(), q)
    steps(5)
    np.testing.assert_allclose(arm.get_joint_positions(), q, atol=1e-3)
    np.testing.assert_allclose(arm.get_joint_target_positions(), q)


def test_target_positions_are_reached_in_steps(arm: Panda) -> None:
    """A target is gone to, not jumped to."""
    q = np.array(arm.get_joint_positions()) + 0.1
    arm.set_joint_target_positions(q)
    np.testing.assert_allclose(arm.get_joint_positions(), q - 0.1)
    steps(4)
    np.testing.assert_allclose(arm.get_joint_positions(), q, atol=3e-3)


def test_target_velocities_move_the_arm_without_the_control_loop(arm: Panda) -> None:
    """Half a radian per second for a fifth of a second is a tenth of a radian; zero stops."""
    arm.set_control_loop_enabled(False)
    start = arm.get_joint_positions()[0]
    arm.set_joint_target_velocities([0.5, 0, 0, 0, 0, 0, 0])
    assert arm.get_joint_target_velocities()[0] == 0.5
    steps(4)
    assert arm.get_joint_positions()[0] - start == pytest.approx(0.1, abs=5e-3)
    assert arm.get_joint_velocities()[0] == pytest.approx(0.5, abs=0.02)
    arm.set_joint_target_velocities([0.0] * 7)
    steps(2)
    assert np.abs(arm.get_joint_velocities()).max() < 0.01
    arm.set_control_loop_enabled(True)
    held = arm.get_joint_positions()
    steps(4)
    np.testing.assert_allclose(arm.get_joint_positions(), held, atol=2e-3)


def test_capped_forces_with_velocities_out_of_reach_are_torques(arm: Panda) -> None:
    """The known way to command torques: the sign by a huge velocity, the size by the cap."""
    runtime = Simulator.current().runtime
    tau = runtime.model.gravity(np.array(arm.get_joint_positions())) + np.array([2.0, 0, 0, 0, 0, 0, 0])
    arm.set_control_loop_enabled(False)
    arm.set_joint_target_velocities(np.sign(tau) * 9999)
    arm.set_joint_forces(np.abs(tau))
    steps(1)
    np.testing.assert_allclose(arm.get_joint_forces(), tau)
    assert arm.get_joint_velocities()[0] > 0.02
    arm.set_joint_target_velocities([0.0] * 7)
    steps(2)
    assert np.abs(arm.get_joint_velocities()).max() < 0.01


def test_the_wrong_number_of_values_is_refused(arm: Panda) -> None:
    """The error says how many joints there are."""
    with pytest.raises(ValueError, match="7 joints, but 3 values"):
        arm.set_joint_target_positions([0, 0, 0])


def test_the_jacobian_has_a_row_per_joint(arm: Panda) -> None:
    """Its transpose maps joint velocities to the tip's velocity, as differences of poses show."""
    q, v = np.array(arm.get_joint_positions()), np.array([0.1, -0.2, 0.3, 0.2, -0.1, 0.3, 0.2])
    jacobian = arm.get_jacobian()
    assert jacobian.shape == (7, 6)
    before = arm.get_tip().get_position()
    arm.set_joint_positions(q + 1e-3 * v)
    np.testing.assert_allclose((arm.get_tip().get_position() - before) / 1e-3, (jacobian.T @ v)[:3], atol=1e-3)


def test_ik_by_jacobian_stays_near_and_refuses_what_is_out_of_reach(arm: Panda) -> None:
    """Three centimetres away is a small change of the joints; five metres away raises."""
    position, quaternion = arm.get_tip().get_position(), arm.get_tip().get_quaternion()
    q = arm.solve_ik_via_jacobian(position + [0.0, 0.03, -0.02], quaternion=quaternion)
    assert isinstance(q, list) and np.abs(np.subtract(q, arm.get_joint_positions())).max() < 0.2
    arm.set_joint_positions(q)
    np.testing.assert_allclose(arm.get_tip().get_position(), position + [0.0, 0.03, -0.02], atol=1e-5)
    with pytest.raises(IKError, match="near the present ones"):
        arm.solve_ik_via_jacobian([5.0, 0.0, 1.0], quaternion=quaternion)


def test_a_pose_without_one_rotation_is_the_error_that_programs_catch(arm: Panda) -> None:
    """No rotation, two rotations or NaN: the error of the call, not another kind."""
    down = {"quaternion": [0.0, 1.0, 0.0, 0.0]}
    with pytest.raises(IKError, match="but not both"):
        arm.solve_ik_via_jacobian([0.3, 0.0, 1.1])
    with pytest.raises(ConfigurationError, match="but not both"):
        arm.solve_ik_via_sampling([0.3, 0.0, 1.1], euler=[0.0, np.pi, 0.0], **down)
    for call in (arm.get_path, arm.get_linear_path, arm.get_nonlinear_path):
        with pytest.raises(ConfigurationPathError, match="but not both"):
            call([0.3, 0.0, 1.1])
        with pytest.raises(ConfigurationPathError, match="finite"):
            call([np.nan, 0.0, 1.1], **down)


def test_ik_accepts_euler_angles_and_frames(arm: Panda) -> None:
    """Angles are those that the tip itself tells; a frame moves the target."""
    tip = arm.get_tip()
    np.testing.assert_allclose(
        arm.solve_ik_via_jacobian(tip.get_position(), euler=tip.get_orientation()), arm.get_joint_positions(), atol=1e-4
    )
    forward = arm.solve_ik_via_jacobian([0, 0, 0.02], quaternion=[0, 0, 0, 1], relative_to=tip)
    ahead = tip.get_position() + 0.02 * tip.get_matrix()[:3, 2]
    arm.set_joint_positions(forward)
    np.testing.assert_allclose(tip.get_position(), ahead, atol=1e-5)
    np.testing.assert_allclose(arm.solve_ik([0, 0, 0], [0, 0, 0], relative_to=tip), forward, atol=1e-4)


def test_ik_by_sampling_gives_several_configurations(arm: Panda) -> None:
    """An array with a row each, all at the pose and different; collisions drop what touches the table."""
    found = arm.solve_ik_via_sampling([0.35, 0.1, 1.0], quaternion=DOWN, max_configs=4)
    assert found.shape == (4, 7)
    assert np.abs(found[0] - found[1]).max() > 0.1
    for q in found:
        np.testing.assert_allclose(Simulator.current().model.tip_pose(q)[:3], [0.35, 0.1, 1.0], atol=1e-5)
    assert np.shape(arm.get_configs_for_tip_pose([0.35, 0.1, 1.0], quaternion=DOWN, max_configs=2)) == (2, 7)
    with pytest.raises(ConfigurationError, match="in collision"):
        arm.solve_ik_via_sampling([0.35, 0.1, 0.75], quaternion=DOWN)
    assert len(arm.solve_ik_via_sampling([0.35, 0.1, 0.75], quaternion=DOWN, ignore_collisions=True)) == 1


def test_settings_of_inverse_kinematics(arm: Panda) -> None:
    """The whole pose can be asked for; leaving a part of it free is refused."""
    arm.set_ik_element_properties()
    arm.set_ik_group_properties("damped_least_squares", 100, 0.1)
    with pytest.raises(UnsupportedCall, match="solve_ik_via_sampling"):
        arm.set_ik_element_properties(constraint_gamma=False)


def test_collisions_of_the_arm(arm: Panda) -> None:
    """At home nothing is touched; bent into the table the arm overlaps the table, and not the wall."""
    table = Shape("diningTable_visible")
    assert not arm.check_arm_collision() and not arm.check_arm_collision(table)
    arm.set_joint_positions([0.0, 1.7, 0.0, -0.3, 0.0, 1.2, 0.78])
    assert arm.check_arm_collision() and arm.check_arm_collision(table)
    assert not arm.check_arm_collision(Shape("Wall1")) and not arm.check_arm_collision(Shape("Panda"))
    table.set_collidable(False)
    assert not arm.check_arm_collision(table)


def test_visuals_are_shapes_of_the_arm(arm: Panda) -> None:
    """Every link that is drawn is a shape with a colour."""
    visuals = arm.get_visuals()
    assert len(visuals) > 7 and all(isinstance(visual, Shape) for visual in visuals)


def test_a_second_arm_and_arms_that_are_missing_are_refused(simulator: Simulator) -> None:
    """The errors say which arm there is."""
    with pytest.raises(UnsupportedCall, match="a world has one robot"):
        Panda(1)
    for missing in (Jaco, UR5, Robotiq85Gripper):
        with pytest.raises(UnsupportedCall, match="the robot of this world is the panda"):
            missing()
    with pytest.raises(NotImplementedError, match="one process per robot"):
        Panda().copy()


def test_constants_that_programs_index() -> None:
    """Twenty colours in their order, and the number of joints of each known robot."""
    assert [name for name, _ in colors][:5] == ["red", "maroon", "lime", "green", "blue"]
    assert len(colors) == 20 and dict(colors)["azure"] == (0.0, 0.5, 1.0)
    assert {name: robot[2] for name, robot in SUPPORTED_ROBOTS.items()} == {
        "panda": 7,
        "jaco": 6,
        "mico": 6,
        "sawyer": 7,
        "ur5": 6,
    }


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


@pytest.mark.simulation
@pytest.mark.parametrize(("setup", "arm", "gripper"), [("ur5", "UR5", "ROBOTIQ_85"), ("jaco", "Jaco", "JacoHand")])
def test_a_program_with_another_arm(setup: str, arm: str, gripper: str) -> None:
    """It steps and gets a demonstration; names of arm, gripper and joints are RLBench's."""
    with Environment(MoveArmThenGripper(JointVelocity(), Discrete()), headless=True, robot_setup=setup) as environment:
        task = environment.get_task(ReachTarget)
        _, observation = task.reset()
        assert observation.joint_positions.shape == (6,)
        task.step(np.zeros(7))
        robot = environment._robot
        assert (robot.arm.get_name(), robot.gripper.get_name()) == (arm, gripper)
        assert [joint.get_name() for joint in robot.arm.joints] == [f"{arm}_joint{k}" for k in range(1, 7)]
        (demo,) = task.get_demos(1, live_demos=True)
        assert task.reset_to_demo(demo)
    for missing in ("sawyer", "mico"):
        with pytest.raises(UnknownRobot, match="jaco, panda, ur5"):
            Environment(MoveArmThenGripper(JointVelocity(), Discrete()), robot_setup=missing)
