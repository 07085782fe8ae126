"""What every task of the registry must keep, asked of each without naming it."""

from __future__ import annotations

import ast
import inspect

import numpy as np
import pytest

from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.environment.motion import REST_SPEED

IDLE_TICKS, RANDOM_TICKS = 200, 200
QUICK_SEEDS, ALL_SEEDS = range(2), range(20)
MAX_PENETRATION = 0.002
REPEATS_ALMOST = {"setup_checkers"}
"""Known fault: contacts of its 24 loose pieces come back in another order, so that late frames differ in the last bits."""
SAME_GOAL_TWICE = {"push_buttons"}
"""Tasks with variations that ask for the same: one of the first buttons of two triples."""


def random_action(task: TaskEnvironment, rng: np.random.Generator) -> np.ndarray:
    """A draw from the whole action space: joint targets anywhere, and a coin for the hand."""
    return rng.uniform(*task.action_bounds())


def test_a_task_file_imports_only_the_task_api_and_numpy(task_env: TaskEnvironment) -> None:
    """Tasks stay free of the simulator and of planners."""
    tree = ast.parse(inspect.getsource(inspect.getmodule(type(task_env.task))))
    modules = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    modules |= {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    assert modules <= {"__future__", "numpy", "rlbench_pin.tasks", "collections.abc", "typing"}


def test_instructions_are_distinct_sentences_for_every_variation(task_env: TaskEnvironment) -> None:
    """Each variation says what to do in at least one sentence, none twice."""
    count = task_env.variation_count()
    assert count >= 1
    seen = set()
    for variation in range(count):
        words, obs = task_env.reset(seed=variation, variation=variation)
        assert words
        assert len(set(words)) == len(words)
        assert all(isinstance(w, str) and w.strip() for w in words)
        assert obs.misc["variation_index"] == variation
        seen.add(tuple(words))
    assert len(seen) == count or task_env.get_name() in SAME_GOAL_TWICE
    task_env.set_variation(0)


def test_the_same_seed_gives_the_same_world(task_env: TaskEnvironment) -> None:
    """Low-dimensional data are finite and byte-equal after another episode."""
    first = task_env.reset(seed=3)[1].get_low_dim_data()
    assert np.isfinite(first).all()
    task_env.reset(seed=4)
    task_env.step(random_action(task_env, np.random.default_rng(0)))
    assert task_env.reset(seed=3)[1].get_low_dim_data().tobytes() == first.tobytes()


def test_the_start_is_at_rest_free_and_not_yet_solved(task_env: TaskEnvironment) -> None:
    """Nothing is held, nothing interpenetrates, nothing is solved, and the arm is still."""
    for seed in QUICK_SEEDS:
        task_env.reset(seed=seed)
        assert task_env.scene.gripper.grasped == ()
        assert task_env.world.max_penetration() < MAX_PENETRATION
        assert np.abs(task_env.get_observation().joint_velocities).max() < REST_SPEED
        assert task_env.task.success() == (False, False)


def test_nothing_moves_by_itself(task_env: TaskEnvironment) -> None:
    """Two seconds after the reset everything is within a millimetre of where it was."""
    task_env.reset(seed=1)
    before = {name: body.position.copy() for name, body in task_env.world.bodies.items()}
    q = task_env.get_observation().joint_positions
    for _ in range(40):
        task_env.step(np.append(q, 1.0))
    for name, body in task_env.world.bodies.items():
        assert np.linalg.norm(body.position - before[name]) < 1e-3, name


@pytest.mark.parametrize("seeds", [QUICK_SEEDS, pytest.param(ALL_SEEDS, marks=pytest.mark.slow)], ids=["quick", "all"])
def test_resting_never_succeeds(task_env: TaskEnvironment, seeds: range) -> None:
    """Doing nothing solves nothing."""
    task_env.set_variation(-1)
    for seed in seeds:
        q = task_env.reset(seed=seed)[1].joint_positions
        for _ in range(IDLE_TICKS):
            _, reward, _ = task_env.step(np.append(q, 1.0))
            assert reward == 0.0, f"seed {seed}"
    task_env.set_variation(0)


@pytest.mark.parametrize("seeds", [QUICK_SEEDS, pytest.param(ALL_SEEDS, marks=pytest.mark.slow)], ids=["quick", "all"])
def test_flailing_never_succeeds(task_env: TaskEnvironment, seeds: range) -> None:
    """Random joint motion solves nothing."""
    if task_env.task.solved_by_chance:
        pytest.skip("a random motion may pass through the goal; `rlbench-pin check` reports how often")
    task_env.set_variation(-1)
    for seed in seeds:
        rng = np.random.default_rng(seed)
        task_env.reset(seed=seed)
        for _ in range(RANDOM_TICKS):
            _, reward, _ = task_env.step(random_action(task_env, rng))
            assert reward == 0.0, f"seed {seed}"
    task_env.set_variation(0)


def test_a_demonstration_succeeds_and_repeats_byte_for_byte(task_env: TaskEnvironment) -> None:
    """Within ten tries a demo reaches the goal and rests; played again it has the same bytes."""
    demos = [task_env.get_demos(1, live_demos=True, seed=7)[0] for _ in range(2)]
    assert np.abs(demos[0][-1].joint_velocities).max() < 0.1
    first, second = (b"".join(o.get_low_dim_data().tobytes() for o in demo) for demo in demos)
    if first != second and task_env.get_name() in REPEATS_ALMOST:
        pytest.xfail("contacts of many loose pieces come back in another order")
    assert first == second


def test_replaying_the_recorded_actions_succeeds(task_env: TaskEnvironment) -> None:
    """Of three demos' joint-position actions, at least two solve the task again through `step`."""
    solved = 0
    for demo in task_env.get_demos(3, live_demos=True, seed=30):
        task_env.reset_to_demo(demo)
        solved += replay(task_env, [o.misc["joint_position_action"] for o in demo[1:]])
    assert solved >= 2


def replay(task: TaskEnvironment, actions: list[np.ndarray]) -> bool:
    """Step through `actions` and up to ten ticks more; whether the goal was reached."""
    for action in [*actions, *[actions[-1]] * 10]:
        _, reward, terminate = task.step(action)
        if terminate:
            return reward == 1.0
    return False
