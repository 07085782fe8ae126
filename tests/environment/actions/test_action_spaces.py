"""Every action space of the paper, absolute and relative: what one action does."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.environment import (
    Discrete,
    EndEffectorPoseViaIK,
    EndEffectorPoseViaPlanning,
    EndEffectorVelocity,
    Environment,
    ERJointViaIK,
    GripperJointPosition,
    JointPosition,
    JointPositionActionMode,
    JointTorque,
    JointVelocity,
    MoveArmThenGripper,
    RelativeFrame,
    TaskEnvironment,
)
from rlbench_pin.environment.actions.modes import ArmActionMode
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.errors import InvalidActionError
from rlbench_pin.spatial import compose, pose_at, relative, rotation_distance

READY = np.array([0.3, 0.1, 1.0, 0.0, 1.0, 0.0, 0.0])
IDENTITY = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
TEN = [
    JointVelocity(),
    JointVelocity(absolute_mode=False),
    JointPosition(),
    JointPosition(absolute_mode=False),
    JointTorque(),
    JointTorque(absolute_mode=False),
    EndEffectorVelocity(),
    EndEffectorVelocity(absolute_mode=False),
    EndEffectorPoseViaIK(),
    EndEffectorPoseViaIK(absolute_mode=False),
]


def episode(arm: ArmActionMode) -> TaskEnvironment:
    """A scene with the gripper pointing down over the table, ready to move anywhere."""
    env = Environment(MoveArmThenGripper(EndEffectorPoseViaPlanning(), Discrete()), obs_config=low_dim_config(), seed=0)
    task = env.get_task("slide_block_to_target")
    task.reset(seed=1)
    task.step(np.append(READY, 1.0))
    task._action_mode = MoveArmThenGripper(arm, Discrete())
    return task


def still(task: TaskEnvironment, arm: ArmActionMode) -> np.ndarray:
    """The action of `arm` that asks for no motion."""
    runtime = task.runtime
    q = runtime.robot.joint_positions
    match arm:
        case JointPosition(absolute_mode=True):
            return q
        case JointTorque(absolute_mode=True):
            return runtime.model.gravity(q)
        case EndEffectorPoseViaIK(absolute_mode=True) | EndEffectorPoseViaPlanning(absolute_mode=True):
            return runtime.robot.tip_pose()
        case EndEffectorPoseViaIK() | EndEffectorPoseViaPlanning():
            return IDENTITY
    return np.zeros(arm.shape(runtime))


@pytest.mark.parametrize("arm", TEN, ids=lambda a: f"{type(a).__name__}-{'absolute' if a.absolute_mode else 'delta'}")
def test_the_action_that_asks_for_nothing_moves_nothing(arm: ArmActionMode) -> None:
    """After it the joints are where they were, and the specification fits the action."""
    task = episode(arm)
    before = task.get_observation().joint_positions
    action = still(task, arm)
    spec = arm.spec(task.runtime)
    assert spec.size == len(action) == len(spec.units)
    assert (spec.low < spec.high).all()
    obs, _, _ = task.step(np.append(action, 1.0))
    assert np.abs(obs.joint_positions - before).max() < 2e-3


@pytest.mark.parametrize(("arm", "tolerance"), [(EndEffectorPoseViaPlanning(False), 1e-3), (EndEffectorPoseViaIK(False), 5e-3)])
def test_ten_centimetres_straight_down_in_the_world(arm: ArmActionMode, tolerance: float) -> None:
    """Planning ends within 1 mm, inverse kinematics within 5 mm."""
    task = episode(arm)
    before = task.get_observation().gripper_pose
    obs, _, _ = task.step([0, 0, -0.1, 0, 0, 0, 1, 1])
    assert np.linalg.norm(obs.gripper_pose[:3] - before[:3] - [0, 0, -0.1]) < tolerance


@pytest.mark.parametrize("mode", [EndEffectorPoseViaPlanning, EndEffectorPoseViaIK])
def test_a_yaw_delta_turns_about_world_z_or_tip_z(mode: type) -> None:
    """30 degrees: in the world frame about world z, in the end-effector frame about the tip's z."""
    yaw = pose_at([0.0, 0.0, 0.0], yaw=np.pi / 6)
    for frame in (RelativeFrame.WORLD, RelativeFrame.EE):
        task = episode(mode(absolute_mode=False, frame=frame))
        before = task.get_observation().gripper_pose
        obs, _, _ = task.step(np.append(yaw, 1.0))
        spin, origin = np.append(np.zeros(3), yaw[3:]), np.append(np.zeros(3), before[3:])
        wanted = compose(spin, origin) if frame is RelativeFrame.WORLD else compose(origin, spin)
        assert rotation_distance(obs.gripper_pose, wanted) < 0.02
        assert np.linalg.norm(obs.gripper_pose[:3] - before[:3]) < 5e-3


def test_a_tip_velocity_moves_along_its_axes() -> None:
    """0.1 m/s for a tick is 5 mm, along world x or along the tip's z."""
    task = episode(EndEffectorVelocity())
    before = task.get_observation().gripper_pose
    obs, _, _ = task.step([0.1, 0, 0, 0, 0, 0, 1])
    assert obs.gripper_pose[0] - before[0] == pytest.approx(0.005, abs=1e-3)
    task = episode(EndEffectorVelocity(frame="end effector"))
    before = task.get_observation().gripper_pose
    obs, _, _ = task.step([0, 0, 0.1, 0, 0, 0, 1])
    assert relative(obs.gripper_pose, before)[2] == pytest.approx(0.005, abs=1e-3)


def test_a_velocity_delta_adds_to_the_measured_velocity() -> None:
    """Two deltas of 0.1 rad/s move at 0.2 rad/s in the second tick."""
    task = episode(JointVelocity(absolute_mode=False))
    push = np.append([0.1] + [0.0] * 6, 1.0)
    task.step(push)
    before = task.get_observation().joint_positions[0]
    obs, _, _ = task.step(push)
    assert obs.joint_positions[0] - before == pytest.approx(0.2 * 0.05, rel=0.1)


def test_torque_beyond_gravity_accelerates_in_its_direction() -> None:
    """3 N m more than gravity on the first joint turns it the positive way."""
    task = episode(JointTorque())
    q = task.get_observation().joint_positions
    torque = task.runtime.model.gravity(q)
    torque[0] += 3.0
    expected = 0.05 * task.runtime.model.forward_dynamics(q, np.zeros(7), torque)[0]
    obs, _, _ = task.step(np.append(torque, 1.0))
    assert obs.joint_velocities[0] == pytest.approx(expected, rel=0.3)
    assert obs.joint_positions[0] > q[0]


def test_after_a_torque_action_the_arm_brakes_and_reports_what_acted() -> None:
    """Ticks that nobody commands stop the arm; until then the torques are those of the action, also after going back to it."""
    task = episode(JointTorque())
    torque = task.runtime.model.gravity(task.get_observation().joint_positions)
    torque[0] += 3.0
    for _ in range(5):
        obs, _, _ = task.step(np.append(torque, 1.0))
    assert obs.joint_velocities[0] > 0.2
    np.testing.assert_array_equal(obs.joint_forces, torque)
    state = task.get_state()
    for _ in range(3):
        task.runtime.step()
    assert np.abs(task.get_observation().joint_velocities).max() < 0.01
    assert np.abs(task.get_observation().joint_forces - torque).max() > 1.0
    back = task.set_state(state)
    np.testing.assert_array_equal(back.joint_forces, torque)
    arrays = task.world.arrays()
    task.runtime.step()
    task.world.set_arrays(arrays)
    np.testing.assert_array_equal(task.get_observation().joint_forces, torque)


def test_torque_actions_in_a_row_do_not_brake() -> None:
    """Five actions move the arm as five ticks of the same torques do, to the last bit."""
    actions, ticks = episode(JointTorque()), episode(JointTorque())
    torque = actions.runtime.model.gravity(actions.get_observation().joint_positions)
    torque[0] += 3.0
    for _ in range(5):
        obs, _, _ = actions.step(np.append(torque, 1.0))
        ticks.runtime.robot.set_torques(torque)
        ticks.runtime.step()
    np.testing.assert_array_equal(obs.joint_positions, ticks.get_observation().joint_positions)
    np.testing.assert_array_equal(obs.joint_velocities, ticks.get_observation().joint_velocities)


def test_torque_differences_add_to_the_torques_of_the_last_action() -> None:
    """A difference of zero repeats them."""
    task = episode(JointTorque(absolute_mode=False))
    gravity = task.runtime.model.gravity(task.get_observation().joint_positions)
    obs, _, _ = task.step(np.append(gravity - task.runtime.robot.joint_torques, 1.0))
    np.testing.assert_allclose(obs.joint_forces, gravity, atol=1e-9)
    obs, _, _ = task.step(np.zeros(8) + np.eye(8)[7])
    np.testing.assert_allclose(obs.joint_forces, gravity, atol=1e-9)


def test_elbow_control_pins_the_named_joint() -> None:
    """The first joint goes where it is told; the tip stays."""
    task = episode(ERJointViaIK(commanded_joints=[0]))
    obs = task.get_observation()
    angle = obs.joint_positions[0] + 0.15
    after, _, _ = task.step([*obs.gripper_pose, angle, 1.0])
    assert after.joint_positions[0] == pytest.approx(angle, abs=5e-3)
    assert np.linalg.norm(after.gripper_pose[:3] - obs.gripper_pose[:3]) < 5e-3
    with pytest.raises(NotImplementedError, match="0 or 6"):
        ERJointViaIK(absolute_mode=False, commanded_joints=[3], delta_angle=True).spec(task.runtime)
    with pytest.raises(InvalidActionError, match="absolute_mode=False"):
        ERJointViaIK(delta_angle=True)


def test_inverse_kinematics_refuses_what_it_cannot_reach() -> None:
    """The refusal changes nothing."""
    task = episode(EndEffectorPoseViaIK())
    before = task.get_observation().get_low_dim_data()
    with pytest.raises(InvalidActionError, match="No joint positions near the present ones"):
        task.step([2.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0])
    with pytest.raises(InvalidActionError, match="norm 0.0000"):
        task.step([0.3, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    assert np.array_equal(task.get_observation().get_low_dim_data(), before)


def test_joint_differences_and_fingers_share_one_tick() -> None:
    """`JointPositionActionMode` takes one tick, with 0.1 rad and 0.04 m as bounds."""
    with Environment(JointPositionActionMode(), obs_config=low_dim_config(), seed=0) as env:
        task = env.get_task("reach_target")
        _, obs = task.reset(seed=0)
        low, high = env.action_bounds()
        assert low.tolist() == [-0.1] * 7 + [0.0]
        assert high.tolist() == [0.1] * 7 + [0.04]
        time = task.world.time
        after, _, _ = task.step([0.01] * 7 + [0.03])
        assert task.world.time - time == pytest.approx(0.05)
        assert np.allclose(after.joint_positions - obs.joint_positions, 0.01, atol=2e-3)
        assert after.gripper_joint_positions.max() < 0.0395


def test_finger_positions_hold_what_stops_them() -> None:
    """Closing step by step on a cube attaches it; opening lets it go."""
    mode = MoveArmThenGripper(EndEffectorPoseViaPlanning(), GripperJointPosition())
    with Environment(mode, obs_config=low_dim_config(), seed=0) as env:
        task = env.get_task("pick_and_lift")
        task.reset(seed=3)
        cube = task.world.body(task.task.get_graspable_objects()[0])
        waypoints = task.task.get_waypoints()
        for waypoint in waypoints[:2]:
            task.step(np.append(waypoint.pose, 0.04))
        here = task.get_observation().gripper_pose
        for _ in range(8):
            task.step(np.append(here, 0.0))
        assert task.runtime.gripper.grasped == (cube.name,)
        for _ in range(4):
            task.step(np.append(here, 0.04))
        assert task.runtime.gripper.grasped == ()
