"""The environment of one task: reset, step, demos, states."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from rlbench_pin import Demo, Observation
from rlbench_pin.environment import Discrete, Environment, JointPosition, MoveArmThenGripper, TaskEnvironment
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.environment.replay import replay_succeeds
from rlbench_pin.errors import (
    DatasetError,
    NoShapedReward,
    NotReset,
    TaskEnvironmentError,
    UnknownArgument,
    UnknownName,
    UsedByTwoThreads,
)


def environment(**settings: object) -> Environment:
    return Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=low_dim_config(), **settings)  # type: ignore[arg-type]


def test_step_before_reset_is_refused() -> None:
    """The error says what to call; it is also a RuntimeError, as existing code expects."""
    with environment() as env:
        task = env.get_task("reach_target")
        with pytest.raises(NotReset, match=r"`step` was called before the first reset. Call `reset\(\)` first"):
            task.step(np.zeros(8))
        with pytest.raises(RuntimeError):
            task.step(np.zeros(8))
        task.reset()
        task.step(np.append(task.get_observation().joint_positions, 1.0))


def test_unknown_tasks_get_the_nearest_name() -> None:
    """A misspelt task names the right one and the command that lists all."""
    with environment() as env, pytest.raises(UnknownName, match=r"Did you mean 'reach_target'\? `rlbench-pin list`"):
        env.get_task("reach_taget")


def test_unknown_robots_and_missing_datasets_are_refused() -> None:
    """Both are found at construction."""
    with pytest.raises(ValueError, match="No robot is called 'pandda'. Did you mean 'panda'"):
        environment(robot_setup="pandda")
    with pytest.raises(RuntimeError, match="does not exist"):
        environment(dataset_root="/nowhere/at/all")
    environment(robot_setup="Panda")


def test_stored_demos_need_a_dataset_root(reach: TaskEnvironment) -> None:
    """Without a root the error says which argument is missing."""
    with pytest.raises(DatasetError, match="No dataset root was given"):
        reach.get_demos(1)


@pytest.mark.simulation
def test_variations_are_checked(reach: TaskEnvironment) -> None:
    """-1 means all; other negatives and too large ones are refused."""
    for wrong in (-2, reach.variation_count()):
        with pytest.raises(TaskEnvironmentError, match="Choose 0 to 19, or -1"):
            reach.set_variation(wrong)
    reach.set_variation(-1)
    seen = {reach.reset(seed=s)[1].misc["variation_index"] for s in range(12)}
    assert len(seen) > 3
    reach.set_variation(0)


@pytest.mark.simulation
def test_the_same_seed_gives_the_same_start(lift: TaskEnvironment) -> None:
    """Bytes are equal after other episodes were played in between."""
    words, first = lift.reset(seed=5, variation=2)
    lift.reset(seed=6, variation=3)
    lift.step(np.append(first.joint_positions + 0.1, 0.0))
    again, second = lift.reset(seed=5, variation=2)
    assert words == again
    assert first.get_low_dim_data().tobytes() == second.get_low_dim_data().tobytes()
    _, other = lift.reset(seed=7, variation=2)
    assert not np.array_equal(first.task_low_dim_state, other.task_low_dim_state)


def test_observations_do_not_share_memory(reach: TaskEnvironment) -> None:
    """Changing one observation changes no other."""
    _, obs = reach.reset(seed=0)
    kept = obs.joint_positions.copy()
    obs.joint_positions += 1.0
    assert np.array_equal(reach.get_observation().joint_positions, kept)


def test_states_can_be_taken_up_again(lift: TaskEnvironment) -> None:
    """From a saved state the same actions give the same bytes."""
    _, obs = lift.reset(seed=2)
    actions = [np.append(obs.joint_positions + 0.02 * k, float(k < 4)) for k in range(8)]
    for action in actions[:3]:
        lift.step(action)
    state = lift.get_state()
    runs = []
    for _ in range(2):
        lift.set_state(state)
        runs.append(b"".join(lift.step(action)[0].get_low_dim_data().tobytes() for action in actions[3:]))
    assert runs[0] == runs[1]


@pytest.mark.simulation
def test_demos_carry_all_that_is_needed_to_play_them_again(lift: TaskEnvironment) -> None:
    """A demo succeeds, rests at its end, and `reset_to_demo` restores its first frame exactly."""
    lift.set_variation(1)
    (demo,) = lift.get_demos(1, live_demos=True, seed=11)
    assert demo.random_seed == 11
    assert demo.variation_number == 1
    assert np.abs(demo[-1].joint_velocities).max() < 0.1
    assert "joint_position_action" not in demo[0].misc
    assert demo[-1].misc["joint_position_action"].shape == (8,)
    lift.reset(seed=99)
    words, obs = lift.reset_to_demo(demo)
    assert tuple(words) == demo.instructions
    assert obs.get_low_dim_data().tobytes() == demo[0].get_low_dim_data().tobytes()
    assert "joint_position_action" not in obs.misc
    lift.set_variation(0)


@pytest.mark.simulation
def test_a_demo_without_a_usable_seed_is_refused(reach: TaskEnvironment) -> None:
    """One unpickled without our fields has none; that of another program is the state of a random number generator."""
    demo = Demo.__new__(Demo)
    demo.__dict__["_observations"] = [Observation()]
    with pytest.raises(TaskEnvironmentError, match="contains no seed"):
        reach.reset_to_demo(demo)
    demo.__dict__["random_seed"] = ("MT19937", np.zeros(624, dtype=np.uint32), 0, 0, 0.0)
    with pytest.raises(TaskEnvironmentError, match="state of a random number generator instead of a seed"):
        reach.reset_to_demo(demo)
    demo.__dict__["random_seed"] = -3
    with pytest.raises(TaskEnvironmentError, match="whole number >= 0 and <= 9223372036854775807. Got -3"):
        reach.reset_to_demo(demo)
    demo.random_seed = 3
    assert reach.reset_to_demo(demo)[0] == reach.reset(seed=3, variation=0)[0]


@pytest.mark.simulation
def test_a_demo_with_the_state_of_a_generator_starts_from_its_snapshot(lift: TaskEnvironment) -> None:
    """Everything stands where it stood, whatever was played before; the demonstration succeeds again from there."""
    demo = lift.get_demos(1, live_demos=True, seed=3)[0]
    np.random.seed(5)  # noqa: NPY002
    demo.random_seed = np.random.get_state()  # noqa: NPY002
    for seed in (1, 2):
        lift.reset(seed=seed)
        descriptions, seen = lift.reset_to_demo(demo)
        assert seen.get_low_dim_data().tobytes() == demo[0].get_low_dim_data().tobytes()
        assert descriptions == list(demo.instructions)
    assert replay_succeeds(lift, demo)


@pytest.mark.simulation
def test_demo_i_starts_from_seed_plus_i(lift: TaskEnvironment) -> None:
    """Two demos from seed 20 are the demos of seeds 20 and 21."""
    both = lift.get_demos(2, live_demos=True, seed=20)
    (second,) = lift.get_demos(1, live_demos=True, seed=21)
    assert [d.random_seed for d in both] == [20, 21]
    assert both[1][-1].get_low_dim_data().tobytes() == second[-1].get_low_dim_data().tobytes()


def test_launching_twice_is_refused_and_shutdown_allows_a_new_launch() -> None:
    """`launch`, `shutdown` and the context manager work together."""
    env = environment()
    env.launch()
    with pytest.raises(RuntimeError, match="already launched"):
        env.launch()
    env.shutdown()
    env.shutdown()
    env.launch()
    assert env.get_task("reach_target").reset(seed=0)[0]
    env.shutdown()


def test_action_size_needs_a_launch() -> None:
    """The arm alone decides; before it is loaded the error says what to call."""
    env = environment()
    for ask in (lambda: env.action_shape, lambda: env.action_size, env.action_bounds):
        with pytest.raises(RuntimeError, match=r"Call `launch\(\)` or `get_task"):
            ask()
    with env:
        before = env.action_bounds()
        assert env.action_shape == (8,)
        task = env.get_task("reach_target")
        assert (env.action_shape, env.action_size) == ((8,), 8)
        assert np.array_equal(before, env.action_bounds())
        assert np.array_equal(before, task.action_bounds())
        assert task.reset(seed=0)[0]


@pytest.mark.parametrize("asks_before", [False, True])
def test_asking_for_the_bounds_first_changes_no_episode(asks_before: bool) -> None:
    """The world in which they are found has no effect on the task's."""
    with environment(seed=0) as env:
        if asks_before:
            env.action_bounds()
        _, obs = env.get_task("reach_target").reset()
    with environment(seed=0) as env:
        _, plain = env.get_task("reach_target").reset()
    assert obs.get_low_dim_data().tobytes() == plain.get_low_dim_data().tobytes()


def test_two_environments_do_not_disturb_each_other() -> None:
    """Stepping one leaves the other as it was."""
    with environment(seed=0) as a, environment(seed=0) as b:
        one, two = a.get_task("reach_target"), b.get_task("pick_and_lift")
        _, obs = one.reset(seed=1)
        two.reset(seed=1)
        for _ in range(5):
            two.step(np.append(two.get_observation().joint_positions + 0.05, 0.0))
        assert one.get_observation().get_low_dim_data().tobytes() == obs.get_low_dim_data().tobytes()


def test_unknown_arguments_name_the_near_one() -> None:
    """Of the environment and of both ways to demonstrations; still a TypeError."""
    with pytest.raises(UnknownArgument, match="No argument of Environment is called 'sede'. Did you mean 'seed'"):
        environment(sede=1)
    with environment() as env:
        for get_demos in (env.get_demos, env.get_task("reach_target").get_demos):
            with pytest.raises(TypeError, match=r"get_demos is called 'amont'. Did you mean 'amount'"):
                get_demos(amont=1)  # type: ignore[call-arg, operator]


def test_two_threads_in_one_environment_are_refused() -> None:
    """While one thread steps, each call of another is a typed error; the first goes on. One after the other they may."""
    with environment() as env:
        task = env.get_task("reach_target")
        task.reset(seed=1)
        action = np.append(task.get_observation().joint_positions, 1.0)
        stepping, checked = threading.Event(), threading.Event()

        def wait() -> None:
            stepping.set()
            checked.wait(60.0)

        task.runtime.after_tick.append(wait)
        with ThreadPoolExecutor(1) as other:
            done = other.submit(task.step, action)
            assert stepping.wait(60.0)
            state_calls = (task.get_state, task.get_observation, lambda: task.step(action), lambda: task.reset(seed=2))
            for call in (*state_calls, lambda: task.get_demos(1, live_demos=True)):
                with pytest.raises(UsedByTwoThreads, match="another thread.*its own environment"):
                    call()
            checked.set()
            assert done.result(60.0)[1] == 0.0
        task.step(action)


def test_shaped_rewards_are_the_tasks_own() -> None:
    """reach_target rewards with minus the distance; a task without one says so."""
    with environment(shaped_rewards=True) as env:
        task = env.get_task("reach_target")
        _, obs = task.reset(seed=1)
        _, reward, _ = task.step(np.append(obs.joint_positions, 1.0))
        distance = np.linalg.norm(task.get_observation().gripper_pose[:3] - task.get_observation().task_low_dim_state)
        assert reward == pytest.approx(-distance, abs=1e-6)
        with pytest.raises(NoShapedReward, match="has no shaped reward. Use shaped_rewards=False") as caught:
            env.get_task("open_drawer")
        assert task.get_observation().joint_positions is not None  # the task before goes on
        assert isinstance(caught.value, TaskEnvironmentError)
        assert isinstance(caught.value, RuntimeError)
