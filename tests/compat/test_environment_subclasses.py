"""Environments, scenes and tasks that programs derive, and several environments in one process."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from pyrep.objects.shape import Shape
from rlbench import Environment, ObservationConfig
from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import EndEffectorPoseViaPlanning, JointVelocity
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.backend.exceptions import InvalidActionError
from rlbench.backend.observation import Observation
from rlbench.backend.scene import Scene
from rlbench.demo import Demo
from rlbench.task_environment import TaskEnvironment
from rlbench.tasks import PickAndLift, PushButton, ReachTarget

pytestmark = pytest.mark.simulation


class CountingScene(Scene):
    """Counts steps, adds to `misc`, forbids half of the workspace."""

    def __init__(self, *args: Any, **settings: Any) -> None:
        self.steps, self.camera_calls, self.placements, self.recorded = 0, 0, 0, 0
        super().__init__(*args, **settings)

    def step(self) -> None:
        """Count."""
        self.steps += 1
        super().step()

    def _set_camera_properties(self) -> None:
        self.camera_calls += 1
        super()._set_camera_properties()

    def _get_misc(self) -> dict[str, Any]:
        return {**super()._get_misc(), "steps": self.steps}

    def _place_task(self) -> None:
        self.placements += 1
        super()._place_task()

    def _demo_record_step(self, demo_list: list[Observation], record: bool, func: Any) -> None:
        self.recorded += 1
        super()._demo_record_step(demo_list, record, func)

    def get_observation(self) -> Observation:
        """Mark."""
        observation = super().get_observation()
        observation.marked = True  # type: ignore[attr-defined]
        return observation


class MyTaskEnvironment(TaskEnvironment):
    """Remembers resets and rewards every step."""

    resets = 0

    def reset(self, demo: Demo | None = None) -> tuple[list[str], Observation]:
        """Count."""
        self.resets += 1
        return super().reset(demo)

    def step(self, action: Any) -> tuple[Observation, float, bool]:
        """Another reward."""
        observation, reward, terminate = super().step(action)
        return observation, reward - 0.5, terminate


class MyEnvironment(Environment):
    """Brings its own scene and task environment; datasets may be missing."""

    def _check_dataset_structure(self) -> None:
        """Nothing."""

    def launch(self) -> None:
        """Take another scene."""
        super().launch()
        self._scene = CountingScene(self._pyrep, self._robot, self._obs_config, self._robot_setup)

    def get_task(self, task_class: Any) -> MyTaskEnvironment:
        """Make the task environment by hand, by position."""
        if self._scene is None:
            self.launch()
        self._scene.unload()
        task = task_class(self._pyrep, self._robot)
        self._prev_task = task
        return MyTaskEnvironment(
            self._pyrep, self._robot, self._scene, task, self._action_mode, self._dataset_root, self._obs_config,
            self._static_positions, self._attach_grasped_objects, self._shaped_rewards,
        )  # fmt: skip


@pytest.fixture(scope="module")
def env() -> Iterator[MyEnvironment]:
    """The environment above."""
    config = ObservationConfig()
    config.set_all_high_dim(False)
    mode = MoveArmThenGripper(EndEffectorPoseViaPlanning(), Discrete())
    environment = MyEnvironment(mode, "/no/such/folder", config, True)
    yield environment
    environment.shutdown()


def test_overridden_methods_are_asked(env: MyEnvironment) -> None:
    """Steps of planned actions and of demonstrations go through the scene; so does every observation."""
    task = env.get_task(PushButton)
    scene = task._scene
    assert isinstance(scene, CountingScene)
    assert scene.camera_calls == 1
    _, observation = task.reset()
    assert task.resets == 1
    assert observation.marked  # type: ignore[attr-defined]
    before = scene.steps
    target = np.append(observation.gripper_pose, 1.0)  # type: ignore[arg-type]
    target[2] -= 0.1
    observation, reward, _ = task.step(target)
    assert reward == -0.5
    assert scene.steps > before + 5
    assert observation.misc["steps"] == scene.steps
    before = scene.steps
    placements = scene.placements
    demo = task.get_demos(1, live_demos=True)[0]
    assert task.resets == 2
    assert scene.placements > placements >= 1
    assert scene.recorded == len(demo)
    assert scene.steps - before >= len(demo) - 3
    assert all(frame.marked for frame in demo)  # type: ignore[attr-defined]
    assert demo[-1].misc["steps"] > demo[0].misc["steps"]


def test_attributes_are_true(env: MyEnvironment) -> None:
    """The underscored attributes that programs read are there and say what is."""
    task = env.get_task(PushButton)
    task.set_variation(2)
    _, observation = task.reset()
    scene = task._scene
    assert (task._task, task._robot, task._pyrep) == (scene.task, scene.robot, scene.pyrep)
    assert (task._variation_number, task._reset_called, scene._variation_index) == (2, True, 2)
    assert scene._has_init_task and scene._has_init_episode
    assert scene._attempts >= 1
    assert task._obs_config is scene._obs_config is scene.get_observation_config() is env._obs_config
    assert scene._cam_front.get_name() == "cam_front"
    assert np.allclose(scene._cam_front.get_position(), [1.35, 0.0, 1.58], atol=1e-3)
    assert scene._cam_wrist_mask.get_name() == "cam_wrist_mask"
    box = scene._workspace_minx, scene._workspace_maxx, scene._workspace_minz, scene._workspace_maxz
    assert box == pytest.approx((-0.274, 0.774, 0.752, 1.752))
    assert np.allclose(scene._start_arm_joint_pos, observation.joint_positions, atol=1e-3)  # type: ignore[arg-type]
    assert len(scene._starting_gripper_joint_pos) == 2
    assert len(scene._robot_shapes) > 3 and len(task._robot_shapes) > 3
    assert scene._workspace.get_name() == "workspace"
    assert scene.check_target_in_workspace([0.3, 0.0, 1.0]) and not scene.check_target_in_workspace([0.3, 0.0, 0.752])


def test_a_scene_may_narrow_its_workspace(env: MyEnvironment) -> None:
    """Planned poses are checked by the scene's own box."""
    task = env.get_task(ReachTarget)
    _, observation = task.reset()
    target = np.append(observation.gripper_pose, 1.0)  # type: ignore[arg-type]
    task._scene._workspace_maxz = float(target[2]) - 0.01
    with pytest.raises(InvalidActionError, match="workspace"):
        task.step(target)
    task._scene._workspace_maxz = 1.752


def test_one_step_callback(env: MyEnvironment) -> None:
    """There is one slot: a second callback takes the place of the first, None empties it."""
    task = env.get_task(ReachTarget)
    task.reset()
    calls: list[str] = []
    task._scene.register_step_callback(lambda: calls.append("first"))
    task._scene.step()
    task._scene.register_step_callback(lambda: calls.append("second"))
    task._scene.step()
    task._scene.register_step_callback(None)
    task._scene.step()
    assert calls == ["first", "second"]


def test_a_scene_alone(env: MyEnvironment) -> None:
    """Programs play episodes with the scene itself: load, init_episode, get_demo, reset."""
    env.get_task(ReachTarget)
    scene = env._scene
    assert scene is not None
    np.random.seed(0)
    descriptions = scene.init_episode(1, max_attempts=10)
    assert descriptions
    frames: list[Observation] = []
    demo = scene.get_demo(record=True, callable_each_step=frames.append, randomly_place=False)
    assert len(demo) == len(frames) > 5
    assert scene.task.success()[0]
    assert scene._joint_position_action is not None and len(scene._joint_position_action) == 8
    scene.reset()
    scene.init_episode(1, max_attempts=10)
    seen: list[Observation] = []
    assert len(scene.get_demo(record=False, callable_each_step=seen.append)) == 0 < len(seen)
    scene.reset()
    assert not scene._has_init_episode
    scene.unload()
    assert scene.task is None
    with pytest.raises(Exception, match="load"):
        scene.init_episode(0)


def test_joint_velocity_mode_after_the_fact(env: MyEnvironment) -> None:
    """The action mode is read at each step, so that programs may exchange it."""
    task = env.get_task(ReachTarget)
    task.reset()
    task._action_mode = MoveArmThenGripper(JointVelocity(), Discrete())
    task.step([0.1] * 7 + [1.0])


class TwiceRecordingScene(Scene):
    """Observes every frame of a demonstration itself, as forks that add to the record do."""

    def _demo_record_step(self, demo_list: list[Observation], record: bool, func: Any) -> None:
        observation = self.get_observation()
        observation.misc["mine"] = len(demo_list)
        demo_list.append(observation)


def test_a_scene_may_record_frames_itself(env: MyEnvironment) -> None:
    """What it puts on the list is the demonstration; the action of the frame is in its `misc`."""
    env.get_task(ReachTarget)
    scene = TwiceRecordingScene(env._pyrep, env._robot, env._obs_config)  # type: ignore[arg-type]
    scene.load(ReachTarget(env._pyrep, env._robot))  # type: ignore[arg-type]
    scene.init_episode(0, max_attempts=10)
    demo = scene.get_demo()
    assert [frame.misc["mine"] for frame in demo] == list(range(len(demo)))
    assert "joint_position_action" not in demo[0].misc
    assert all(len(frame.misc["joint_position_action"]) == 8 for frame in demo[1:])
    assert demo.random_seed is not None


class OwnResetTaskEnvironment(TaskEnvironment):
    """Resets with the scene's methods alone, as extension projects do."""

    def reset(self, demo: Demo | None = None) -> tuple[list[str], Observation]:
        """Without a word about the demonstration."""
        self._scene.reset()
        descriptions = self._scene.init_episode(self._variation_number, max_attempts=40, randomly_place=True)
        self._reset_called = True
        return descriptions, self._scene.get_observation()


def test_an_own_reset_goes_back_to_demos(env: MyEnvironment) -> None:
    """`reset_to_demo`, sentences and live demonstrations work with a reset that knows nothing of them."""
    task: Any = env.get_task(ReachTarget)
    own = OwnResetTaskEnvironment(
        env._pyrep, env._robot, env._scene, task._task, env._action_mode, "", env._obs_config, False, True
    )  # type: ignore[arg-type]
    own.set_variation(3)
    demo = own.get_demos(1, live_demos=True)[0]
    descriptions, other = own.reset()
    assert descriptions == own.get_task_descriptions()
    _, start = own.reset_to_demo(demo)
    assert np.allclose(start.joint_positions, demo[0].joint_positions)  # type: ignore[arg-type]
    assert own.runtime.world.body("target").pose[:3] == pytest.approx(_target_of(own, demo))
    assert start.misc["variation_index"] == 3
    assert other.misc["variation_index"] == 3


def _target_of(task: TaskEnvironment, demo: Demo) -> np.ndarray:
    """Return where the target stood when the demonstration was made, from its snapshot."""
    task.reset()
    assert demo.state is not None
    task.runtime.world.set_arrays(demo.state)
    return np.array(task.runtime.world.body("target").pose[:3])


STILL = np.array([0.0] * 7 + [1.0])


@pytest.fixture
def two() -> Iterator[tuple[Environment, Environment]]:
    """Two launched environments without images."""
    config = ObservationConfig()
    config.set_all_high_dim(False)
    config.task_low_dim_state = True
    both = tuple(Environment(MoveArmThenGripper(JointVelocity(), Discrete()), obs_config=config, headless=True) for _ in range(2))
    for env in both:
        env.launch()
    yield both[0], both[1]
    for env in both:
        env.shutdown()


def test_they_take_turns(two: tuple[Environment, Environment]) -> None:
    """Each steps and resets its own task; views look at the environment that was used last."""
    reach = two[0].get_task(ReachTarget)
    _, first = reach.reset()
    lift = two[1].get_task(PickAndLift)
    _, other = lift.reset()
    assert Shape.exists("block") and not Shape.exists("target")
    observation, _, _ = reach.step(STILL)
    assert np.allclose(observation.task_low_dim_state, first.task_low_dim_state)
    assert np.allclose(Shape("target").get_position(), first.task_low_dim_state)
    assert np.allclose(lift.get_observation().task_low_dim_state, other.task_low_dim_state, atol=1e-3)
    assert Shape.exists("block")


def test_one_outlives_the_other(two: tuple[Environment, Environment]) -> None:
    """After a shutdown of one, the other goes on."""
    reach = two[0].get_task(ReachTarget)
    _, first = reach.reset()
    two[1].get_task(PickAndLift).reset()
    two[1].shutdown()
    observation, _, _ = reach.step(STILL)
    assert np.allclose(observation.task_low_dim_state, first.task_low_dim_state)
    demo = reach.get_demos(1, live_demos=True)[0]
    assert np.linalg.norm(demo[-1].gripper_pose[:3] - demo[-1].task_low_dim_state) < 0.03
