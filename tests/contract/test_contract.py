"""What every task of the registry must keep, asked of each without naming it.

This is the quick form: one demonstration played twice, one replay, one seed of rest and flailing. Its longer half is marked
`slow`; the long form is `make sweep`: `rlbench-pin check` with 100 demonstrations and 20 seeds.
"""

from __future__ import annotations

import ast
import inspect

import numpy as np
import pytest

from rlbench_pin.checking import judge
from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.environment.motion import REST_SPEED
from rlbench_pin.observation import Demo

SHORT = 60
"""Control ticks of resting and flailing in the quick form; 3 s."""


def long(*values: int) -> object:
    """A case of the long form."""
    return pytest.param(*values, marks=pytest.mark.slow)


def test_a_task_file_imports_only_the_task_api_and_numpy(task_env: TaskEnvironment) -> None:
    """Tasks stay free of the simulator and of planners."""
    tree = ast.parse(inspect.getsource(inspect.getmodule(type(task_env.task))))
    modules = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    modules |= {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    assert modules <= {"__future__", "numpy", "rlbench_pin.tasks", "collections.abc", "typing"}


def test_instructions_are_distinct_sentences_for_every_variation(task_env: TaskEnvironment) -> None:
    """Each variation says what to do in at least one sentence, none twice, and in other words than the others."""
    count = task_env.variation_count()
    assert count >= 1
    words = {}
    for variation in range(count):
        words[variation], obs = task_env.reset(seed=variation, variation=variation)
        assert all(isinstance(w, str) for w in words[variation])
        assert obs.misc["variation_index"] == variation
    assert judge.poor_instructions(words) == ()
    assert task_env.task.variations_share_goals is bool(judge.shared_instructions(words))
    task_env.set_variation(0)


def test_the_same_seed_gives_the_same_world(task_env: TaskEnvironment) -> None:
    """Low-dimensional data are finite and byte-equal after another episode."""
    first = task_env.reset(seed=3)[1].get_low_dim_data()
    assert np.isfinite(first).all()
    task_env.reset(seed=4)
    task_env.step(np.random.default_rng(0).uniform(*task_env.action_bounds()))
    assert task_env.reset(seed=3)[1].get_low_dim_data().tobytes() == first.tobytes()


@pytest.mark.parametrize(("seed", "steps"), [(0, SHORT), long(1, judge.IDLE_STEPS)])
def test_a_scene_left_alone_stays_as_it_is(task_env: TaskEnvironment, seed: int, steps: int) -> None:
    """At the reset nothing is held or overlaps and the arm is still; then nothing moves by itself, and nothing is solved."""
    found = judge.rest(task_env, seed, -1, steps)
    assert found.held == ()
    assert found.penetration <= judge.MAX_PENETRATION
    assert found.arm_speed < REST_SPEED
    assert not found.success
    assert found.drift <= judge.MAX_DRIFT, found.drifter
    task_env.set_variation(0)


@pytest.mark.parametrize(("seed", "steps"), [(0, SHORT), long(0, judge.RANDOM_STEPS)])
def test_flailing_never_succeeds(task_env: TaskEnvironment, seed: int, steps: int) -> None:
    """Random joint motion solves nothing."""
    if task_env.task.solved_by_chance:
        pytest.skip("a random motion may pass through the goal; `rlbench-pin check` reports how often")
    assert not judge.flail_succeeds(task_env, seed, -1, steps)
    task_env.set_variation(0)


def test_a_demonstration_repeats_replays_and_leaves_nothing_over(task_env: TaskEnvironment) -> None:
    """Within ten tries a demo reaches the goal and rests; the next episode starts as usual, the recorded actions succeed again.

    Where the replay fails, those of two more demonstrations have to succeed. Played again, the demonstration has the same bytes.
    """
    demo = demonstrate(task_env, 7)
    assert np.abs(demo[-1].joint_velocities).max() < 0.1
    assert replays(task_env, demo) or all(replays(task_env, demonstrate(task_env, seed)) for seed in (30, 31))
    assert judge.demo_bytes(demonstrate(task_env, 7)) == judge.demo_bytes(demo)


@pytest.mark.slow
def test_of_three_replays_two_succeed(task_env: TaskEnvironment) -> None:
    """And after none of the episodes anything is left over."""
    assert sum(replays(task_env, demonstrate(task_env, seed)) for seed in (30, 31, 32)) >= 2


def demonstrate(task_env: TaskEnvironment, seed: int) -> Demo:
    """Return a demonstration."""
    return task_env.get_demos(1, live_demos=True, seed=seed)[0]


def replays(task_env: TaskEnvironment, demo: Demo) -> bool:
    """Whether the joint-position actions of a demonstration just played succeed again; nothing may be left over from it."""
    assert judge.left_over(task_env, demo) == ()
    return judge.replay_succeeds(task_env, demo)
