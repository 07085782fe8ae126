"""Whatever velocities a policy asks for, and for however long, the arm behind the filter breaks no limit and touches nothing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from rlbench_pin.environment import Discrete, Environment, JointVelocity, MoveArmThenGripper, SafeArm, TaskEnvironment
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.spatial import FloatArray

DRAGGED = [[2.03, -1.61, 2.05, 1.64, 0.84, 0.82, 0.8]]
"""From home, this drags the light third joint along with the heavy first one."""
STRETCHED = [
    [-0.93, -0.93, 0.03, 1.86, 0.77, -1.04, -0.56],
    [1.31, -1.9, -1.64, -1.38, -2.02, -0.5, -2.01],
    [-0.42, -1.92, 1.33, 0.74, -0.2, 0.48, -1.94],
    [-2.05, -0.83, 1.51, 1.04, -1.1, 1.75, 1.28],
    [-1.28, 1.61, -0.61, 0.06, 1.37, 1.41, 1.7],
    [-1.07, 0.12, 2.07, -1.97, -1.76, 0.35, -0.03],
    [1.28, 0.2, 0.4, 2.04, -1.42, -0.68, 2.39],
    [-1.88, -2.01, -1.68, 0.8, -2.56, 2.43, 0.54],
    [-1.93, 2.06, 1.68, -1.99, 1.99, -0.08, -2.59],
    [-0.24, 1.17, 1.62, -1.33, -2.35, -0.57, 2.22],
]
"""These end with the arm stretched out backwards, where gravity leaves the second joint's motor little to brake with."""


def broken(task: TaskEnvironment, actions: Sequence[Sequence[float]] | FloatArray, hold: int) -> list[str]:
    """Play joint velocities [rad/s], each for `hold` ticks; return what was broken, and when."""
    robot, limits, dt, found = task.world.robot, task.runtime.model.limits, task.world.control_dt, []
    before = robot.joint_velocities
    for tick in range(hold * len(actions)):
        task.step([*actions[tick // hold], 1.0])
        q, v = robot.joint_positions, robot.joint_velocities
        share = np.abs(v - before) / dt / limits.acceleration
        if (share > 1.01).any():
            found.append(f"tick {tick}: joint {share.argmax() + 1} accelerates with {share.max():.3f} of its limit")
        if (np.abs(v) > 1.001 * limits.velocity).any():
            found.append(f"tick {tick}: too fast, {v}")
        if not limits.contains(q, 1e-6):
            found.append(f"tick {tick}: beyond a joint limit, {q}")
        if robot.touching():
            found.append(f"tick {tick}: touches {robot.touching()}")
        before = v
    return found


def play_random(name: str, episodes: int, hold: int, seed: int) -> list[str]:
    """Play random joint velocities of full range in the scene of a task, 120 ticks an episode; return what was broken."""
    rng, found = np.random.default_rng(seed), []
    with Environment(MoveArmThenGripper(SafeArm(JointVelocity()), Discrete()), obs_config=low_dim_config(), seed=0) as env:
        task = env.get_task(name)
        fastest = task.runtime.model.limits.velocity
        for episode in range(episodes):
            task.reset(seed=seed + episode)
            actions = rng.uniform(-fastest, fastest, (120 // hold, len(fastest)))
            found += [f"{name}, hold {hold}, episode {episode}, {what}" for what in broken(task, actions, hold)]
    return found


@pytest.mark.simulation
@pytest.mark.parametrize("actions", [DRAGGED, STRETCHED], ids=["dragged", "stretched"])
def test_motors_follow_what_the_filter_passes_on(actions: list[list[float]]) -> None:
    """Two motions in which motors once ended a tick elsewhere than commanded, beyond limits of the third and second joint."""
    with Environment(MoveArmThenGripper(SafeArm(JointVelocity()), Discrete()), obs_config=low_dim_config(), seed=3) as env:
        task = env.get_task("meat_off_grill" if actions is DRAGGED else "pick_and_lift")
        task.reset(seed=1100054)
        assert broken(task, actions, 6) == []


@pytest.mark.simulation
@pytest.mark.parametrize("hold", [1, 6, 12])
def test_random_velocities_break_nothing(hold: int) -> None:
    """Three episodes in the scene with most things to touch."""
    assert play_random("meat_off_grill", 3, hold, seed=7) == []


@pytest.mark.slow
@pytest.mark.parametrize("hold", [1, 6, 12])
@pytest.mark.parametrize("name", ["meat_off_grill", "open_drawer", "put_rubbish_in_bin", "stack_blocks"])
def test_many_random_velocities_break_nothing(name: str, hold: int) -> None:
    """Thirty episodes in each of four scenes; `benchmarks/bench_safety.py` plays all scenes for as long as wanted."""
    assert play_random(name, 30, hold, seed=100) == []
