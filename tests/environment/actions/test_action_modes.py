"""What actions do, and how they are refused."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.environment import (
    Discrete,
    EndEffectorPoseViaPlanning,
    Environment,
    JointPosition,
    JointVelocity,
    MoveArmThenGripper,
    RelativeFrame,
    TaskEnvironment,
)
from rlbench_pin.environment.actions.modes import ArmActionMode, calculate_delta_pose
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.environment.runtime import TIP_WORKSPACE
from rlbench_pin.errors import InvalidActionError
from rlbench_pin.spatial import above_table, pose_at, rotation_distance

DOWN = np.array([0.3, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0])


def episode(arm: ArmActionMode, task: str = "reach_target") -> TaskEnvironment:
    env = Environment(MoveArmThenGripper(arm, Discrete()), obs_config=low_dim_config(), seed=0)
    task_env = env.get_task(task)
    task_env.reset(seed=1)
    return task_env


def test_joint_velocity_moves_for_one_tick_and_stops() -> None:
    """A velocity is held for one tick; afterwards the arm rests."""
    task = episode(JointVelocity())
    before = task.get_observation().joint_positions
    action = np.zeros(8)
    action[0], action[7] = 0.5, 1.0
    after, reward, terminate = task.step(action)
    assert after.joint_positions[0] - before[0] == pytest.approx(0.025, abs=0.003)
    rest, _, _ = task.step(np.append(np.zeros(7), 1.0))
    assert np.abs(rest.joint_velocities).max() < 0.01
    assert (reward, terminate) == (0.0, False)


def test_absolute_joint_positions_are_reached_in_time() -> None:
    """Repeating a near target brings the arm there."""
    task = episode(JointPosition())
    target = task.get_observation().joint_positions + 0.05
    for _ in range(3):
        obs, _, _ = task.step(np.append(target, 1.0))
    assert np.abs(obs.joint_positions - target).max() < 2e-3


def test_joint_position_deltas_add_to_the_measured_posture() -> None:
    """Six deltas of 0.01 rad move each joint by about 0.06 rad."""
    task = episode(JointPosition(absolute_mode=False))
    before = task.get_observation().joint_positions
    for _ in range(6):
        obs, _, _ = task.step(np.append(np.full(7, 0.01), 1.0))
    assert np.abs(obs.joint_positions - before - 0.06).max() < 0.05


@pytest.mark.parametrize("checking", [False, True])
def test_planning_reaches_a_pose(checking: bool) -> None:
    """The planned motion ends on the pose, at rest."""
    task = episode(EndEffectorPoseViaPlanning(collision_checking=checking), "slide_block_to_target")
    obs, _, _ = task.step(np.append(DOWN, 1.0))
    assert np.linalg.norm(obs.gripper_pose[:3] - DOWN[:3]) < 2e-3
    assert rotation_distance(obs.gripper_pose, DOWN) < 5e-3
    assert np.abs(obs.joint_velocities).max() < 0.1


def test_a_world_delta_turns_about_the_world_and_a_hand_delta_about_the_hand() -> None:
    """The rotation is multiplied from the left in the world frame, from the right in the end-effector frame."""
    current = pose_at([0.3, 0.1, 1.0], roll=np.pi, yaw=0.4)
    yaw = pose_at([0.01, 0.02, 0.03], yaw=0.5)
    world = calculate_delta_pose(current, yaw)
    assert np.allclose(world, pose_at([0.31, 0.12, 1.03], roll=np.pi, yaw=0.9)) or np.allclose(
        world[3:], -pose_at([0, 0, 0], roll=np.pi, yaw=0.9)[3:]
    )
    hand = calculate_delta_pose(current, yaw, RelativeFrame.EE)
    assert rotation_distance(hand, pose_at([0, 0, 0], roll=np.pi, yaw=-0.1)) < 1e-6
    assert hand[2] == pytest.approx(0.97)


def test_ten_centimetres_straight_down() -> None:
    """A relative planning action in the world frame moves the tip straight down."""
    task = episode(EndEffectorPoseViaPlanning(absolute_mode=False), "slide_block_to_target")
    before = task.get_observation().gripper_pose
    obs, _, _ = task.step([0, 0, -0.1, 0, 0, 0, 1, 1])
    assert np.linalg.norm(obs.gripper_pose[:3] - before[:3] - [0, 0, -0.1]) < 1e-3
    assert rotation_distance(obs.gripper_pose, before) < 5e-3


@pytest.mark.parametrize(
    ("action", "says"),
    [
        (np.zeros(5), r"shape \(8,\), not \(5,\)"),
        (np.full(8, np.nan), "NaN or infinity at index 0, 1"),
        (np.append(np.zeros(7), 2.0), "must be between 0"),
        ("left", "takes 8 numbers"),
    ],
)
def test_malformed_actions_are_refused_and_change_nothing(reach: TaskEnvironment, action: object, says: str) -> None:
    """A refused action names the fault; the world is as it was and goes on working."""
    _, before = reach.reset(seed=3)
    with pytest.raises(InvalidActionError, match=says):
        reach.step(action)
    assert np.array_equal(reach.get_observation().get_low_dim_data(), before.get_low_dim_data())
    reach.step(np.append(before.joint_positions, 1.0))


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("side", [0, 1])
def test_targets_outside_each_face_of_the_workspace_are_refused(axis: int, side: int) -> None:
    """Each face of the box is checked, strictly, and named."""
    task = episode(EndEffectorPoseViaPlanning())
    before = task.get_observation().get_low_dim_data()
    target = DOWN.copy()
    target[axis] = TIP_WORKSPACE[side, axis]
    with pytest.raises(InvalidActionError, match=f"{'xyz'[axis]} must be between"):
        task.step(np.append(target, 1.0))
    assert np.array_equal(task.get_observation().get_low_dim_data(), before)


def test_bad_quaternions_and_unreachable_poses_are_refused() -> None:
    """The norm is named; an unreachable pose carries how near the arm gets."""
    task = episode(EndEffectorPoseViaPlanning())
    before = task.get_observation().get_low_dim_data()
    with pytest.raises(InvalidActionError, match="norm 2.0000. Divide it by its norm"):
        task.step([0.3, 0, 1, 0, 0, 0, 2, 1])
    with pytest.raises(InvalidActionError, match=r"cannot reach .* mm and .* deg away"):
        task.step([0.77, 0.65, above_table(0.998), 0, 0, 0, 1, 1])
    assert np.array_equal(task.get_observation().get_low_dim_data(), before)
    task.step(np.append(DOWN, 1.0))


def test_every_mode_states_bounds() -> None:
    """Bounds have the shape of an action and are ordered."""
    for arm in (JointVelocity(), JointPosition(), JointPosition(False), EndEffectorPoseViaPlanning()):
        task = episode(arm)
        low, high = MoveArmThenGripper(arm, Discrete()).bounds(task.runtime)
        assert low.shape == high.shape == (arm.shape(task.runtime)[0] + 1,)
        assert (low < high).all()


def test_the_gripper_closes_opens_and_ignores_repeats() -> None:
    """Closing shuts the fingers; asking again costs no time."""
    task = episode(JointPosition())
    q = task.get_observation().joint_positions
    obs, _, _ = task.step(np.append(q, 0.0))
    assert obs.gripper_open == 0.0
    assert obs.gripper_joint_positions.max() < 1e-3
    time = task.world.time
    task.step(np.append(q, 0.0))
    assert task.world.time - time == pytest.approx(0.05)
    obs, _, _ = task.step(np.append(q, 1.0))
    assert obs.gripper_open == 1.0
