"""Environment and TaskEnvironment under the known names: constructor orders, the loop, seeds, errors."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import rlbench
from rlbench import Environment, ObservationConfig
from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import JointVelocity
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.backend.exceptions import InvalidActionError, TaskEnvironmentError
from rlbench.backend.observation import Observation
from rlbench.backend.scene import STEPS_BEFORE_EPISODE_START, Scene
from rlbench.environment import DIR_PATH, SUPPORTED_ROBOTS
from rlbench.task_environment import _MAX_DEMO_ATTEMPTS, _MAX_RESET_ATTEMPTS, TaskEnvironment
from rlbench.tasks import OpenDrawer, PushButton, ReachTarget
from rlbench_pin import observation as native_observation

pytestmark = pytest.mark.simulation

REST = [0.0] * 7 + [1.0]


def low_dim() -> ObservationConfig:
    """Joint, gripper and task data, no images."""
    config = ObservationConfig()
    config.set_all_high_dim(False)
    config.set_all_low_dim(True)
    return config


def make(**settings: object) -> Environment:
    """Return an environment of joint velocities."""
    config = settings.pop("obs_config", low_dim())
    return Environment(MoveArmThenGripper(JointVelocity(), Discrete()), obs_config=config, headless=True, **settings)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def env() -> Iterator[Environment]:
    """A launched environment without images."""
    environment = make()
    environment.launch()
    yield environment
    environment.shutdown()


@pytest.fixture(scope="module")
def reach(env: Environment) -> TaskEnvironment:
    """The reach task, reset once."""
    task = env.get_task(ReachTarget)
    np.random.seed(0)
    task.reset()
    return task


def test_names_and_limits() -> None:
    """What is imported from where, and the numbers that programs import."""
    assert sorted(rlbench.__all__) == [
        "ActionMode", "ArmActionMode", "CameraConfig", "Environment", "GripperActionMode", "ObservationConfig",
        "RandomizeEvery", "VisualRandomizationConfig",
    ]  # fmt: skip
    assert "reach_target.py" in rlbench.TASKS
    assert all(rlbench.name_to_task_class(name) for name in rlbench.TASKS[:3])
    assert rlbench.__version__
    assert (_MAX_RESET_ATTEMPTS, _MAX_DEMO_ATTEMPTS, STEPS_BEFORE_EPISODE_START) == (40, 10, 10)
    assert set(SUPPORTED_ROBOTS) >= {"panda", "ur5"}
    assert Path(DIR_PATH).is_dir()
    assert Observation is native_observation.Observation


def test_parameter_orders() -> None:
    """Programs pass these by position, and one counts the parameters of `init_episode`."""
    assert list(inspect.signature(Environment).parameters) == [
        "action_mode", "dataset_root", "obs_config", "headless", "static_positions", "robot_setup", "randomize_every",
        "frequency", "visual_randomization_config", "dynamics_randomization_config", "attach_grasped_objects",
        "shaped_rewards", "arm_max_velocity", "arm_max_acceleration",
    ]  # fmt: skip
    assert list(inspect.signature(TaskEnvironment).parameters)[:7] == [
        "pyrep", "robot", "scene", "task", "action_mode", "dataset_root", "obs_config",
    ]  # fmt: skip
    assert len(inspect.signature(Scene.init_episode).parameters) == 5
    assert list(inspect.signature(Scene.get_demo).parameters) == ["self", "record", "callable_each_step", "randomly_place"]


def test_the_loop(env: Environment) -> None:
    """Reset gives sentences and an observation, a step three values; the shape of actions is known after launch."""
    assert env.action_shape == (8,)
    assert env.action_size == 8
    task = env.get_task(ReachTarget)
    assert (task.get_name(), task.variation_count()) == ("reach_target", 20)
    with pytest.raises(RuntimeError, match="before the first reset"):
        task.step(REST)
    descriptions, first = task.reset()
    assert descriptions == task.get_task_descriptions()
    observation, reward, terminate = task.step([0.5, 0, 0, 0, 0, 0, 0, 1.0])
    assert (reward, terminate) == (0.0, False)
    assert observation.joint_positions is not None and first.joint_positions is not None
    assert observation.joint_positions[0] > first.joint_positions[0] + 0.005
    with pytest.raises(InvalidActionError):
        task.step([0.0] * 3)
    assert np.array_equal(task.get_observation().joint_positions, observation.joint_positions)  # type: ignore[arg-type]


def test_the_global_generator_decides(reach: TaskEnvironment) -> None:
    """The same seed of numpy's global generator gives the same variation, episode and demonstration; another one does not."""

    def outcome(seed: int) -> tuple[int, bytes, bytes]:
        np.random.seed(seed)
        variation = reach.sample_variation()
        _, first = reach.reset()
        demo = reach.get_demos(1, live_demos=True)[0]
        assert first.task_low_dim_state is not None and demo[-1].joint_positions is not None
        return variation, first.task_low_dim_state.tobytes(), demo[-1].joint_positions.tobytes()

    one, again, other = outcome(3), outcome(3), outcome(4)
    assert one == again
    assert one[1:] != other[1:]
    reach.set_variation(0)


def test_variations(reach: TaskEnvironment) -> None:
    """What there is not is refused; -1 stands for all of them."""
    for v in (20, -2):
        with pytest.raises(TaskEnvironmentError, match="no variation"):
            reach.set_variation(v)
    reach.set_variation(-1)
    np.random.seed(5)
    drawn = set()
    for _ in range(4):
        _, observation = reach.reset()
        drawn.add(observation.misc["variation_index"])
    assert len(drawn) > 1
    reach.set_variation(0)


def test_live_demos_and_back(reach: TaskEnvironment) -> None:
    """A demonstration carries what restores its start, and calls back for every frame."""
    frames: list[Observation] = []
    np.random.seed(1)
    demo = reach.get_demos(1, live_demos=True, callable_each_step=frames.append)[0]
    assert len(frames) == len(demo) > 10
    assert isinstance(demo.random_seed, int)
    assert demo.num_reset_attempts is not None and demo.num_reset_attempts >= 1
    assert len(demo[1].misc["joint_position_action"]) == 8
    np.random.seed(99)
    _, start = reach.reset_to_demo(demo)
    assert np.array_equal(start.task_low_dim_state, demo[0].task_low_dim_state)  # type: ignore[arg-type]
    _, start = reach.reset(demo)
    assert np.array_equal(start.task_low_dim_state, demo[0].task_low_dim_state)  # type: ignore[arg-type]
    assert "joint_position_action" not in start.misc
    np.random.seed(demo.random_seed)  # as `demo.restore_state()` does
    _, start = reach.reset()
    assert np.array_equal(start.task_low_dim_state, demo[0].task_low_dim_state)  # type: ignore[arg-type]
    _, start = reach.reset()
    assert not np.array_equal(start.task_low_dim_state, demo[0].task_low_dim_state)  # type: ignore[arg-type]


def test_the_task_is_replaced(env: Environment) -> None:
    """Getting another task unloads the one before; `_prev_task` and the scene follow."""
    env.get_task(PushButton).reset()
    task = env.get_task(OpenDrawer)
    task.reset()
    assert env._prev_task is task._task is task._scene.task
    assert task.get_name() == "open_drawer"
    assert "chest" in task.runtime.world.bodies


def test_errors_of_construction(tmp_path: Path) -> None:
    """Wrong arguments are found at once, with the types that programs catch."""
    with pytest.raises(RuntimeError, match="does not exist"):
        make(dataset_root=str(tmp_path / "nowhere"))
    with pytest.raises(ValueError, match="pandaa"):
        make(robot_setup="pandaa")
    with pytest.raises(ValueError, match="randomiz"):
        make(randomize_every=rlbench.RandomizeEvery.EPISODE)
    assert make(robot_setup="Panda")._robot_setup == "panda"
    environment = make()
    with pytest.raises(RuntimeError, match="launch"):
        _ = environment.action_shape
    with pytest.raises(RuntimeError, match="dataset_root"):
        environment.get_demos("reach_target", 1)
    with pytest.raises(RuntimeError):
        environment._string_to_task("no_such_task")
    assert environment._string_to_task("reach_target") is ReachTarget
    environment.shutdown()


def test_launching_twice(env: Environment) -> None:
    """A second launch is refused; after a shutdown, which may be repeated, it works."""
    with pytest.raises(RuntimeError, match="already launched"):
        env.launch()
    env.shutdown()
    env.shutdown()
    env.launch()
    env.get_task(ReachTarget).reset()


def test_shaped_rewards() -> None:
    """The task's own reward is returned, and a task without one says so."""
    with make(shaped_rewards=True) as environment:
        task = environment.get_task(ReachTarget)
        task.reset()
        assert task.step(REST)[1] < 0.0
        task = environment.get_task(PushButton)
        task.reset()
        with pytest.raises(RuntimeError, match="shaped reward"):
            task.step(REST)


def test_scene_data() -> None:
    """Cameras are described whether the environment is launched or not; those switched off are None."""
    config = ObservationConfig()
    config.wrist_camera.set_all(False)
    environment = make(obs_config=config)
    for _ in range(2):
        data = environment.get_scene_data()
        assert data["wrist_camera"] is None
        front = data["front_camera"]
        assert front is not None
        assert sorted(front) == ["extrinsics", "far_plane", "intrinsics", "near_plane"]
        assert front["intrinsics"][0, 0] == pytest.approx(-175.84, abs=0.01)
        if environment._pyrep is None:
            environment.launch()
    environment.shutdown()
