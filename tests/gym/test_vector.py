"""Four environments side by side, in one process and in four."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence

from rlbench_pin.environment import Discrete, EndEffectorVelocity, MoveArmThenGripper
from rlbench_pin.gym.environment import GymnasiumEnv
from rlbench_pin.gym.ids import gym_id

TASK = "open_drawer"


def play(env: gymnasium.vector.VectorEnv[Any, Any, Any], steps: int = 4) -> list[Any]:
    """Return what a few steps of fixed actions yield."""
    rng = np.random.default_rng(0)
    low, high = env.action_space.low, env.action_space.high  # type: ignore[attr-defined]
    start = env.reset(seed=[1, 2, 3, 4])[0]
    return [start, *(env.step(rng.uniform(low, high).astype(np.float32))[:4] for _ in range(steps))]


def alone() -> list[list[Any]]:
    """Return what the same episodes yield one after the other."""
    episodes = []
    with GymnasiumEnv(TASK) as env:
        for index in range(4):
            rng = np.random.default_rng(0)
            low, high = np.tile(env.action_space.low, (4, 1)), np.tile(env.action_space.high, (4, 1))
            first = env.reset(seed=index + 1)[0]
            episodes.append([first, *(env.step(rng.uniform(low, high).astype(np.float32)[index])[0] for _ in range(4))])
    return episodes


def same(vector: list[Any], single: list[list[Any]]) -> bool:
    """Whether each row of the vector episodes is the single one."""
    observations = [vector[0], *(step[0] for step in vector[1:])]
    return all(
        np.array_equal(observation[name][row], single[row][t][name])
        for row in range(4)
        for t, observation in enumerate(observations)
        for name in observation
    )


@pytest.mark.simulation
def test_four_in_one_process_are_as_four_alone() -> None:
    """A synchronous vector environment plays the very episodes of single ones."""
    env = gymnasium.make_vec(gym_id(TASK, "state"), num_envs=4, vectorization_mode="sync")
    together = play(env)
    assert env.reset(seed=0)[1]["text_descriptions"].shape == (4,)
    env.close()
    assert same(together, alone())


@pytest.mark.slow
@pytest.mark.parametrize("context", ["spawn", "fork"])
def test_four_processes_are_as_one(context: str) -> None:
    """An asynchronous vector environment plays the same episodes, however its processes start."""
    sync = gymnasium.make_vec(gym_id(TASK, "state"), num_envs=4, vectorization_mode="sync")
    env = gymnasium.make_vec(gym_id(TASK, "state"), num_envs=4, vectorization_mode="async", vector_kwargs={"context": context})
    results = play(sync), play(env)
    for vector in (sync, env):
        vector.close()
    assert data_equivalence(results[0], results[1])


@pytest.mark.slow
def test_spawned_processes_know_the_ids_and_take_action_modes() -> None:
    """An id with its package before the colon is made in a process that has imported nothing, with an action mode of ours."""
    mode = MoveArmThenGripper(EndEffectorVelocity(), Discrete())
    name = f"rlbench_pin:{gym_id('reach_target', 'vision')}"
    makers = [lambda: gymnasium.make(name, action_mode=mode, image_size=(32, 32))] * 2
    env = gymnasium.vector.AsyncVectorEnv(makers, context="spawn")
    env.reset(seed=0)
    observation, reward, *_ = env.step(env.action_space.sample())
    env.close()
    assert observation["wrist_rgb"].shape == (2, 32, 32, 3) and reward.shape == (2,)


def test_a_refused_action_is_reported_for_its_own_environment() -> None:
    """In a vector environment only the row that was refused carries an error."""
    makers = [lambda: GymnasiumEnv("reach_target", action_mode=MoveArmThenGripper(EndEffectorVelocity(), Discrete()))] * 2
    env = gymnasium.vector.SyncVectorEnv(makers)
    env.reset(seed=0)
    actions = np.zeros((2, 7), dtype=np.float32)
    actions[1, 6] = 7.0
    *_, info = env.step(actions)
    env.close()
    assert info["_error"].tolist() == [False, True] and "gripper" in info["error"][1]
