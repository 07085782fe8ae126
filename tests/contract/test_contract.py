"""What every task of the registry must keep, asked of each without naming it.

This is the quick form: one demonstration played twice, one replay, one seed of the no-op and the random policy. Its longer half
is marked `slow`; the long form is `make sweep`: `rlbench-pin check` with 100 demonstrations and 20 seeds.
"""

from __future__ import annotations

import ast
import inspect
from itertools import pairwise

import numpy as np
import pytest

from rlbench_pin.checking import validate
from rlbench_pin.datasets import key_frame_actions, key_frames
from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.environment.presets import key_frame_mode
from rlbench_pin.environment.replay import replay_succeeds
from rlbench_pin.environment.runtime import REST_SPEED
from rlbench_pin.errors import InvalidActionError
from rlbench_pin.observation import Demo

MAX_KEYS = 25
"""Most key frames of a demonstration of a task of `PERACT`; agents end an episode after as many."""
PERACT = (
    "insert_onto_square_peg", "light_bulb_in", "meat_off_grill", "open_drawer", "place_cups", "place_shape_in_shape_sorter",
    "push_buttons", "put_groceries_in_cupboard", "stack_blocks",
)  # fmt: skip
"""The tasks of the library that are among the 18 of multi-task key-frame agents."""
SHORT = 60
"""Control ticks of the no-op and the random policy in the quick form; 3 s."""


def long(*values: int) -> object:
    """A case of the long form."""
    return pytest.param(*values, marks=pytest.mark.slow)


def test_a_task_file_imports_only_the_task_api_and_numpy(task_env: TaskEnvironment) -> None:
    """Tasks stay free of the simulator and of planners; a task may extend another."""
    tree = ast.parse(inspect.getsource(inspect.getmodule(type(task_env.task))))
    modules = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    modules |= {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    modules = {module for module in modules if not module.startswith("rlbench_pin.tasks.library.")}
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
    assert validate.poor_instructions(words) == ()
    assert task_env.task.variations_share_goals is bool(validate.shared_instructions(words))
    task_env.set_variation(0)


def test_the_same_seed_gives_the_same_world(task_env: TaskEnvironment) -> None:
    """Low-dimensional data are finite and byte-equal after another episode."""
    first = task_env.reset(seed=3)[1].get_low_dim_data()
    assert np.isfinite(first).all()
    task_env.reset(seed=4)
    task_env.step(np.random.default_rng(0).uniform(*task_env.action_bounds()))
    assert task_env.reset(seed=3)[1].get_low_dim_data().tobytes() == first.tobytes()


@pytest.mark.parametrize(("seed", "steps"), [(0, SHORT), long(1, validate.NOOP_STEPS)])
def test_a_scene_left_alone_stays_as_it_is(task_env: TaskEnvironment, seed: int, steps: int) -> None:
    """At the reset nothing is held or overlaps and the arm is still; then nothing moves by itself, and nothing is solved."""
    found = validate.noop_episode(task_env, seed, -1, steps)
    assert found.held == ()
    assert found.penetration <= validate.MAX_PENETRATION
    assert found.arm_speed < REST_SPEED
    assert not found.success
    assert found.drift <= validate.MAX_DRIFT, found.drifter
    task_env.set_variation(0)


@pytest.mark.parametrize(("seed", "steps"), [(0, SHORT), long(0, validate.RANDOM_STEPS)])
def test_random_actions_never_succeed(task_env: TaskEnvironment, seed: int, steps: int) -> None:
    """Random joint motion solves nothing."""
    if task_env.task.solved_by_chance:
        pytest.skip("a random motion may pass through the goal; `rlbench-pin check` reports how often")
    assert not validate.random_succeeds(task_env, seed, -1, steps)
    task_env.set_variation(0)


def test_a_demonstration_repeats_replays_and_leaves_nothing_over(task_env: TaskEnvironment) -> None:
    """Within ten tries a demo reaches the goal and rests; the next episode starts as usual, the recorded actions succeed again.

    Where the replay fails, those of two more demonstrations have to succeed. Played again, the demonstration has the same bytes.
    """
    demo = demonstrate(task_env, 7)
    assert np.abs(demo[-1].joint_velocities).max() < 0.1
    assert replays(task_env, demo) or all(replays(task_env, demonstrate(task_env, seed)) for seed in (30, 31))
    assert validate.demo_bytes(demonstrate(task_env, 7)) == validate.demo_bytes(demo)


@pytest.mark.slow
def test_of_three_replays_two_succeed(task_env: TaskEnvironment) -> None:
    """And after none of the episodes anything is left over."""
    assert sum(replays(task_env, demonstrate(task_env, seed)) for seed in (30, 31, 32)) >= 2


def test_key_frames_reach_the_goal(task_env: TaskEnvironment) -> None:
    """The rule of agents finds few, none in the first frame and no two close together; planned again, they succeed.

    Where they do not, those of two more demonstrations have to succeed.
    """
    demo = demonstrate(task_env, 8)
    keys = key_frames(demo)
    assert np.abs(demo[1].joint_velocities).max() > 0.1
    assert all(later - earlier > 2 for earlier, later in pairwise(keys))
    assert len(keys) <= (MAX_KEYS if task_env.get_name() in PERACT else 2 * MAX_KEYS)
    assert key_replays(task_env, demo) or all(key_replays(task_env, demonstrate(task_env, seed)) for seed in (40, 41))


@pytest.mark.slow
def test_of_five_demonstrations_the_key_frames_of_four_reach_the_goal(task_env: TaskEnvironment) -> None:
    """As agents with perfect key frames would do."""
    assert sum(key_replays(task_env, demonstrate(task_env, seed)) for seed in range(50, 55)) >= 4


def key_replays(task_env: TaskEnvironment, demo: Demo) -> bool:
    """Whether the key frames of a demonstration, planned again with the flags of their segments, reach the goal."""
    task_env.reset_to_demo(demo)
    mode = key_frame_mode()
    for action in key_frame_actions(demo):
        try:
            with task_env.runtime.acting() as result:  # success is evaluated in every tick
                mode.action(task_env.runtime, action)
        except InvalidActionError:
            return False
        if result.success:
            return True
    return False


def demonstrate(task_env: TaskEnvironment, seed: int) -> Demo:
    """Return a demonstration."""
    return task_env.get_demos(1, live_demos=True, seed=seed)[0]


def replays(task_env: TaskEnvironment, demo: Demo) -> bool:
    """Whether the joint-position actions of a demonstration just played succeed again; nothing may be left over from it."""
    assert validate.left_over(task_env, demo) == ()
    return replay_succeeds(task_env, demo)
