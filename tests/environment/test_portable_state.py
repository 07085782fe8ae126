"""A state that was pickled continues in another process as it does here."""

from __future__ import annotations

import multiprocessing
import pickle
from typing import Any

import numpy as np
import pytest

from rlbench_pin.environment import EnvironmentState, TaskEnvironment
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.errors import TaskEnvironmentError
from rlbench_pin.observation import LOW_DIM, Observation

pytestmark = pytest.mark.simulation
STEPS = 12


def actions(start: Observation, count: int = STEPS) -> list[np.ndarray]:
    """Return joint positions that swing about those of an observation, and a gripper that closes."""
    assert start.joint_positions is not None
    swing = 0.15 * np.sin(np.linspace(0.2, 3.0, count))
    joints = start.joint_positions + np.outer(swing, [1.0, 1.0, -1.0, 1.0, 0.5, 1.0, 1.0])
    return [np.append(q, float(i < count // 2)) for i, q in enumerate(joints)]


def numbers(observation: Observation) -> dict[str, np.ndarray]:
    """Return what an observation says without images."""
    return {name: np.asarray(value) for name in LOW_DIM if (value := getattr(observation, name)) is not None}


def continued(task: TaskEnvironment, state: EnvironmentState) -> list[dict[str, Any]]:
    """Go back to a state and step on; return everything that is observed, the rewards and the ends."""
    observation = task.set_state(state)
    first = numbers(observation)
    first.pop("joint_forces")  # those of the last tick, which this server may not have played
    seen: list[dict[str, Any]] = [first]
    for action in actions(observation):
        observation, reward, terminate = task.step(action)
        seen.append({**numbers(observation), "reward": reward, "terminate": terminate})
    return [*seen, {"instructions": task.get_task_descriptions(), "seed": task.seed}]


def continue_elsewhere(name: str, pickled: bytes) -> list[dict[str, Any]]:
    """Do so in the process that calls this, where nothing has happened yet."""
    with make_environment(low_dim_config()) as environment:
        return continued(environment.get_task(name), pickle.loads(pickled))


def assert_same(one: list[dict[str, Any]], other: list[dict[str, Any]]) -> None:
    """Compare to the last bit."""
    assert len(one) == len(other)
    for index, (a, b) in enumerate(zip(one, other)):
        assert a.keys() == b.keys()
        differing = [key for key in a if not np.array_equal(a[key], b[key])]
        assert differing == [], f"step {index}: {[(a[k], b[k]) for k in differing]}"


EPISODES = (("reach_target", 3), ("push_buttons", 20), ("take_lid_off_saucepan", 0), ("stack_blocks", 4), ("beat_the_buzz", 0))


@pytest.mark.parametrize(("name", "variation"), EPISODES)
def test_a_state_continues_in_another_process(name: str, variation: int) -> None:
    """Bit for bit, from the middle of an episode, though the other process began no episode."""
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task(name)
        _, observation = task.reset(seed=5, variation=variation)
        for action in actions(observation, 8):
            task.step(action)
        state = task.get_state()
        pickled = pickle.dumps(state)
        here = continued(task, state)
    context = multiprocessing.get_context("spawn")
    with context.Pool(1) as pool:
        there = pool.apply(continue_elsewhere, (name, pickled))
    assert_same(here, there)


def test_a_state_outlives_its_environment_and_travels_twice() -> None:
    """It is plain data once it was pickled, and can be used, and pickled, again and again."""
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task("push_button")
        task.reset(seed=1)
        state = task.get_state()
        here = continued(task, state)
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task("push_button")
        task.set_variation(-1)
        again = pickle.loads(pickle.dumps(pickle.loads(pickle.dumps(state))))
        assert_same(continued(task, again), here)
        task.reset(seed=9)
        assert_same(continued(task, again), here)
        follow_up = task.get_state()
        assert_same(continued(task, pickle.loads(pickle.dumps(follow_up))), continued(task, follow_up))


def test_a_state_of_another_task_is_refused() -> None:
    """With both names; nothing has changed."""
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task("push_button")
        task.reset(seed=1)
        pickled = pickle.dumps(task.get_state())
        other = environment.get_task("reach_target")
        with pytest.raises(TaskEnvironmentError, match="'push_button', but this environment runs 'reach_target'"):
            other.set_state(pickle.loads(pickled))


def test_states_are_not_taken_for_each_other() -> None:
    """Moments of one episode come back in any order, here and unpickled."""
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task("take_lid_off_saucepan")
        _, observation = task.reset(seed=2)
        states = []
        for action in actions(observation, 6):
            task.step(action)
            states.append(task.get_state())
        here = [continued(task, state) for state in states]
        for index in (3, 0, 5, 3):
            assert_same(continued(task, states[index]), here[index])
            assert_same(continued(task, pickle.loads(pickle.dumps(states[index]))), here[index])
        assert any(not np.array_equal(a["joint_positions"], b["joint_positions"]) for a, b in zip(here[0][:-1], here[5][:-1]))
