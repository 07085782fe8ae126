"""A safety filter in front of an action mode."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.environment import (
    Discrete,
    Environment,
    JointPosition,
    JointVelocity,
    MoveArmThenGripper,
    SafeArm,
    TaskEnvironment,
)
from rlbench_pin.environment.actions.modes import ArmActionMode
from rlbench_pin.environment.presets import low_dim_config


def drive_down(arm: ArmActionMode) -> tuple[TaskEnvironment, float]:
    """Drive the arm into the table for three seconds; return the environment and the deepest penetration [m]."""
    task = Environment(MoveArmThenGripper(arm, Discrete()), obs_config=low_dim_config(), seed=0).get_task("reach_target")
    _, obs = task.reset(seed=0)
    deepest = 0.0
    for _ in range(60):
        action = np.zeros(8)
        action[1], action[3], action[7] = 0.8, -0.4, 1.0
        if isinstance(getattr(arm, "mode", arm), JointPosition):
            action[:7] = task.get_observation().joint_positions + 0.05 * action[:7]
        task.step(action)
        deepest = max(deepest, task.world.max_penetration() if "table" in task.world.robot.touching() else 0.0)
    return task, deepest


def test_without_the_filter_the_arm_hits_the_table() -> None:
    """The policy is a bad one."""
    task, _ = drive_down(JointVelocity())
    assert "table" in task.world.robot.touching()


@pytest.mark.simulation
def test_with_the_filter_it_stops_in_front_of_it() -> None:
    """The same policy never touches; the filter says why it intervened."""
    for inner in (JointVelocity(), JointPosition()):
        arm = SafeArm(inner)
        task, deepest = drive_down(arm)
        assert task.world.robot.touching() == ()
        assert deepest == 0.0
        assert arm.counts.interventions > 0
        assert any("table" in pair for pair in arm.last.pairs)


def test_harmless_actions_pass_unchanged() -> None:
    """Slow motion in free space is not touched."""
    arm = SafeArm(JointVelocity())
    task = Environment(MoveArmThenGripper(arm, Discrete()), obs_config=low_dim_config(), seed=0).get_task("reach_target")
    _, before = task.reset(seed=0)
    for _ in range(5):
        obs, _, _ = task.step([0.1] + [0.0] * 6 + [1.0])
    assert arm.counts.interventions == 0
    assert obs.joint_positions[0] - before.joint_positions[0] > 0.02
