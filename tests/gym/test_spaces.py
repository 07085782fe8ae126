"""Spaces that hold: what observations and actions consist of, in every action mode and variation."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rlbench_pin.environment import (
    EndEffectorPoseViaIK,
    EndEffectorPoseViaPlanning,
    EndEffectorVelocity,
    ERJointViaIK,
    GripperJointPosition,
    JointPosition,
    JointTorque,
    JointVelocity,
    MoveArmThenGripper,
)
from rlbench_pin.gym import GymnasiumEnv
from rlbench_pin.tasks import task_names

ARMS = (
    JointVelocity(),
    JointPosition(),
    JointPosition(absolute_mode=False),
    JointTorque(),
    EndEffectorVelocity(),
    EndEffectorPoseViaIK(),
    EndEffectorPoseViaPlanning(absolute_mode=False),
    ERJointViaIK(),
)


@pytest.mark.parametrize(
    "arm", ARMS, ids=lambda arm: f"{type(arm).__name__}{'' if getattr(arm, 'absolute_mode', 1) else '-delta'}"
)
def test_random_actions_of_every_mode_stay_in_the_spaces(arm: Any) -> None:
    """Bounds are finite in every action mode, random actions are taken, and observations lie in their space."""
    with GymnasiumEnv("open_drawer", action_mode=MoveArmThenGripper(arm, GripperJointPosition())) as env:
        assert np.isfinite(env.action_space.low).all() and np.isfinite(env.action_space.high).all()
        env.action_space.seed(1)
        obs, _ = env.reset(seed=1)
        for _ in range(8):
            assert obs in env.observation_space
            obs, reward, terminated, truncated, info = env.step(env.action_space.sample())
            assert (type(reward), type(terminated), truncated) == (float, bool, False)
            assert info["success"] is info["is_success"]
        assert obs in env.observation_space


def test_observations_carry_what_the_interface_promises(reach: GymnasiumEnv) -> None:
    """The state has the eight named boxes in float32, and each row says where the ball is."""
    obs, info = reach.reset(seed=3)
    shapes = {name: value.shape for name, value in obs.items()}
    assert shapes == {
        "joint_velocities": (7,),
        "joint_positions": (7,),
        "joint_forces": (7,),
        "gripper_open": (1,),
        "gripper_pose": (7,),
        "gripper_joint_positions": (2,),
        "gripper_touch_forces": (6,),
        "task_low_dim_state": (3,),
    }
    assert {value.dtype for value in obs.values()} == {np.dtype(np.float32)}
    ball = reach.task_environment.world.body("target").pose[:3]
    np.testing.assert_allclose(obs["task_low_dim_state"], ball, atol=1e-6)
    assert info["text_descriptions"] == reach.task_environment.get_task_descriptions()


def test_vision_adds_four_pictures() -> None:
    """Vision observations hold four images of the asked size, and the images show something."""
    with GymnasiumEnv("reach_target", "vision", image_size=(48, 32)) as env:
        obs, _ = env.reset(seed=0)
        assert obs in env.observation_space
        for camera in ("left_shoulder", "right_shoulder", "wrist", "front"):
            assert obs[f"{camera}_rgb"].shape == (32, 48, 3)
            assert obs[f"{camera}_rgb"].std() > 5.0


@pytest.mark.slow
@pytest.mark.parametrize("task", task_names())
def test_task_state_has_one_length(task: str) -> None:
    """No variation has a longer or shorter task state than the space says, so nothing is filled up."""
    with GymnasiumEnv(task) as env:
        size = env.observation_space["task_low_dim_state"].shape[0]
        count = env.task_environment.variation_count()
        for variation in np.unique(np.linspace(0, count - 1, min(count, 4)).round().astype(int)):
            env.reset(seed=0, options={"variation": variation})
            assert len(env.task_environment.task.get_low_dim_state()) == size
