"""What every task of the registry must keep, asked of each without naming it.

This is the quick form, on few seeds; the long one is `make sweep`: `rlbench-pin check` with 100 demonstrations and 20 seeds.
"""

from __future__ import annotations

import ast
import inspect

import numpy as np
import pytest

from rlbench_pin.checking import judge
from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.environment.motion import REST_SPEED

REST_SEEDS, FLAIL_SEEDS = range(2), range(1)


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


def test_a_scene_left_alone_stays_as_it_is(task_env: TaskEnvironment) -> None:
    """At the reset nothing is held or overlaps and the arm is still; then nothing moves by itself, and nothing is solved."""
    for seed in REST_SEEDS:
        found = judge.rest(task_env, seed, -1)
        assert found.held == ()
        assert found.penetration <= judge.MAX_PENETRATION, f"seed {seed}"
        assert found.arm_speed < REST_SPEED
        assert not found.success, f"seed {seed}"
        assert found.drift <= judge.MAX_DRIFT, f"seed {seed}: {found.drifter}"
    task_env.set_variation(0)


def test_flailing_never_succeeds(task_env: TaskEnvironment) -> None:
    """Random joint motion solves nothing."""
    if task_env.task.solved_by_chance:
        pytest.skip("a random motion may pass through the goal; `rlbench-pin check` reports how often")
    for seed in FLAIL_SEEDS:
        assert not judge.flail_succeeds(task_env, seed, -1), f"seed {seed}"
    task_env.set_variation(0)


def test_a_demonstration_succeeds_and_repeats_byte_for_byte(task_env: TaskEnvironment) -> None:
    """Within ten tries a demo reaches the goal and rests; played again it has the same bytes."""
    demos = [task_env.get_demos(1, live_demos=True, seed=7)[0] for _ in range(2)]
    assert np.abs(demos[0][-1].joint_velocities).max() < 0.1
    first, second = (b"".join(o.get_low_dim_data().tobytes() for o in demo) for demo in demos)
    assert first == second


def test_nothing_is_left_over_and_replaying_the_actions_succeeds(task_env: TaskEnvironment) -> None:
    """After an episode the next one starts as ever; of three demos' joint-position actions, at least two succeed again."""
    solved = 0
    for demo in task_env.get_demos(3, live_demos=True, seed=30):
        assert judge.left_over(task_env, demo) == ()
        solved += judge.replay_succeeds(task_env, demo)
    assert solved >= 2
