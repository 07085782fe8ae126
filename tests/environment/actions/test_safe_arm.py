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


def towards_a_body(task: TaskEnvironment, rng: np.random.Generator) -> np.ndarray:
    """Return joint velocities [rad/s] that move the tip to a random point of a random body at 0.3 m/s, turning at random."""
    bodies = [body for body in task.world.snapshot().bodies if body.collides and not body.in_room]
    poses = bodies[rng.integers(len(bodies))].link_poses
    q, model = task.world.robot.joint_positions, task.runtime.model
    way = poses[rng.integers(len(poses)), :3] + rng.normal(scale=0.1, size=3) - task.world.robot.tip_pose()[:3]
    twist = np.concatenate([0.3 * way / np.linalg.norm(way), rng.normal(scale=0.5, size=3)])
    return np.linalg.pinv(model.jacobian(q, "world"), rcond=0.05) @ twist


@pytest.mark.simulation
def test_fingers_that_have_no_room_do_not_open() -> None:
    """The shut gripper is driven close to surfaces, then told to open: nothing is ever touched, and some openings are refused."""
    refused = 0
    for name in ("open_fridge", "turn_tap", "open_window", "close_drawer"):
        with Environment(MoveArmThenGripper(SafeArm(JointVelocity()), Discrete()), obs_config=low_dim_config(), seed=0) as env:
            task, rng, touched = env.get_task(name), np.random.default_rng(7), set[str]()
            for seed in range(3):
                task.reset(seed=seed)
                task.step([0.0] * 7 + [0.0])
                with task.runtime.calling(after=lambda task=task, touched=touched: touched.update(task.world.robot.touching())):
                    for _ in range(12):
                        way = towards_a_body(task, rng)
                        for _ in range(12):
                            task.step([*way, 0.0])
                        task.step([0.0] * 7 + [1.0])
                        refused += task.refused_opening is not None
                        if task.refused_opening is None:
                            task.step([0.0] * 7 + [0.0])
            assert not touched, f"{name}: {sorted(touched)}"
    assert refused > 0
