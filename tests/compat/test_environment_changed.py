"""Programs that change parts of a running environment: places of tasks, paths, start joints, demonstrations."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from pyrep.robots.configuration_paths.arm_configuration_path import ArmConfigurationPath
from rlbench import Environment, ObservationConfig
from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import EndEffectorPoseViaPlanning
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.backend.exceptions import InvalidActionError
from rlbench.backend.scene import Scene
from rlbench.backend.spawn_boundary import BoundingBox, SpawnBoundary
from rlbench.demo import Demo
from rlbench.tasks import PushButton, ReachTarget, StackBlocks, TakeLidOffSaucepan
from rlbench_pin.environment.episode import EpisodeRandom

pytestmark = pytest.mark.simulation


@pytest.fixture
def env() -> Iterator[Environment]:
    """A running environment without cameras whose arm goes to poses."""
    config = ObservationConfig()
    config.set_all_high_dim(False)
    environment = Environment(MoveArmThenGripper(EndEffectorPoseViaPlanning(), Discrete()), obs_config=config, headless=True)
    environment.launch()
    yield environment
    environment.shutdown()


def place_of(task: Any) -> np.ndarray:
    """Return where the task stands on the workspace plane, x, y, z [m]."""
    return np.array(task._task.get_base().get_position(relative_to=task._scene._workspace))


def test_tasks_are_placed_by_the_workspace_boundary(env: Environment, monkeypatch: pytest.MonkeyPatch) -> None:
    """A program that says where the boundary puts objects, and that everything fits, gets the task there."""
    task = env.get_task(PushButton)
    area = task._scene._workspace_boundary._boundaries[0]
    monkeypatch.setattr(BoundingBox, "within_boundary", lambda *_: True)
    monkeypatch.setattr(area, "_get_position_within_boundary", lambda obj, box: [0.05, 0.1, 0.0])
    for _ in range(2):
        task.reset()
        assert place_of(task) == pytest.approx([0.05, 0.1, 0.0], abs=1e-6)


def test_a_replaced_sample_is_asked_for_the_base(env: Environment, monkeypatch: pytest.MonkeyPatch) -> None:
    """`SpawnBoundary.sample` places the base of the task, with the rotation bounds that the task says."""
    original, asked = SpawnBoundary.sample, []

    def watched(boundary: SpawnBoundary, obj: Any, **settings: Any) -> None:
        asked.append((obj.get_name(), tuple(settings["min_rotation"])))
        original(boundary, obj, **{**settings, "min_rotation": (0, 0, 0), "max_rotation": (0, 0, 0)})

    monkeypatch.setattr(SpawnBoundary, "sample", watched)
    task = env.get_task(PushButton)
    task.reset()
    assert asked[-1] == ("push_button", task._task.base_rotation_bounds()[0])
    assert task._task.get_base().get_orientation() == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)


def test_rotation_bounds_of_the_object_hold(env: Environment, monkeypatch: pytest.MonkeyPatch) -> None:
    """`base_rotation_bounds` that a program puts on the task object is asked at every reset."""
    task = env.get_task(TakeLidOffSaucepan)
    monkeypatch.setattr(task._task, "base_rotation_bounds", lambda: ((0.0, 0.0, 0.3), (0.0, 0.0, 0.301)))
    for _ in range(3):
        task.reset()
        assert 0.3 <= task._task.get_base().get_orientation()[2] <= 0.301


def test_one_seed_places_as_the_library_does(env: Environment) -> None:
    """Where no program interferes, the workspace boundary draws the very places of the native placement."""
    task = env.get_task(StackBlocks)
    world, native = task._scene.runtime.world, task._task.native
    for seed in range(3):
        native.place(EpisodeRandom.from_seed(seed).placement)
        expected = np.array(world.root.pose)
        task._scene.place(EpisodeRandom.from_seed(seed).placement)
        assert world.root.pose == pytest.approx(expected, abs=1e-12)


def test_pose_actions_go_where_a_replaced_get_path_leads(env: Environment, monkeypatch: pytest.MonkeyPatch) -> None:
    """The arm object is asked for the path; a path of the program's own is followed by its `step`."""
    task, arm = env.get_task(ReachTarget), env._robot.arm
    _, start = task.reset()
    goal = np.append(start.gripper_pose - [0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.0], 1.0)
    asked: list[bool] = []

    def straight(position: Any, euler: Any = None, quaternion: Any = None, ignore_collisions: bool = False, **_: Any) -> Any:
        asked.append(ignore_collisions)
        return arm.get_linear_path(position, euler, quaternion, ignore_collisions=ignore_collisions)

    monkeypatch.setattr(arm, "get_path", straight)
    observation, _, _ = task.step(goal)
    assert asked == [True] and observation.gripper_pose[:3] == pytest.approx(goal[:3], abs=5e-3)
    monkeypatch.setattr(arm, "get_path", lambda *_, **__: TwoSteps(arm))
    before = observation.joint_positions
    observation, _, _ = task.step(goal)
    assert 0.01 < observation.joint_positions[0] - before[0] < 0.1


class TwoSteps:
    """A path of a program's own: the first joint turns a little, twice."""

    def __init__(self, arm: Any) -> None:
        self.arm, self.left = arm, 2

    def step(self) -> bool:
        """Command a little turn."""
        target = np.array(self.arm.get_joint_positions())
        target[0] += 0.03
        self.arm.set_joint_target_positions(target)
        self.left -= 1
        return self.left == 0


def test_refused_poses_name_the_path_error_as_cause(env: Environment) -> None:
    """What agents catch is InvalidActionError; its cause is the ConfigurationPathError of the arm."""
    task = env.get_task(ReachTarget)
    task.reset()
    with pytest.raises(InvalidActionError, match="No motion to the target pose") as caught:
        task.step([0.7, 0.6, 1.7, 0.0, 0.0, 0.0, 1.0, 1.0])
    assert type(caught.value.__cause__).__name__ == "ConfigurationPathError"


def test_the_pace_of_the_arm_holds_in_pose_actions(env: Environment) -> None:
    """A slower arm takes more steps for the same pose."""
    task, counted = env.get_task(ReachTarget), []
    for pace in (1.0, 0.3):
        env._robot.arm.max_velocity = pace
        np.random.seed(0)
        _, start = task.reset()
        began = task.runtime.world.time
        task.step(np.append(start.gripper_pose - [0.0, 0.0, 0.15, 0.0, 0.0, 0.0, 0.0], 1.0))
        counted.append(task.runtime.world.time - began)
    assert counted[1] > 1.5 * counted[0]


def test_the_arm_starts_where_the_scene_says(env: Environment) -> None:
    """`_start_arm_joint_pos` of the scene holds for resets, demonstrations, and their repetition."""
    task = env.get_task(PushButton)
    joints = np.array(task._scene._start_arm_joint_pos)
    joints[0] += 0.3
    task._scene._start_arm_joint_pos = joints
    _, start = task.reset()
    assert start.joint_positions == pytest.approx(joints, abs=0.01)
    (demo,) = task.get_demos(1, live_demos=True)
    assert demo[0].joint_positions == pytest.approx(joints, abs=0.01)
    _, again = task.reset_to_demo(demo)
    assert again.joint_positions == pytest.approx(demo[0].joint_positions, abs=1e-6)


class BareScene(Scene):
    """Its demonstrations are observations and nothing else."""

    def get_demo(self, *_: Any, **__: Any) -> Demo:
        """Return two frames."""
        observations = [self.get_observation()]
        self.step()
        return Demo([*observations, self.get_observation()])


def test_demos_of_bare_observations_can_be_started_again(env: Environment) -> None:
    """A demonstration that a scene of a program made is told its seed, its variation and its task, and starts again."""
    env._scene = BareScene(env._pyrep, env._robot, env._obs_config)
    task = env.get_task(PushButton)
    task.set_variation(3)
    (demo,) = task.get_demos(1, live_demos=True)
    assert isinstance(demo.random_seed, int) and (demo.task_name, demo.variation_number) == ("push_button", 3)
    place = place_of(task)
    task.set_variation(0)
    task.reset()
    assert place_of(task) != pytest.approx(place, abs=1e-3)
    task.reset_to_demo(demo)
    assert place_of(task) == pytest.approx(place, abs=1e-6) and task._variation_number == 3


def test_library_tasks_show_what_they_keep(env: Environment) -> None:
    """`task._task.target` and the like are objects of the scene; other names, and names before loading, are refused."""
    with pytest.raises(AttributeError, match="target"):
        _ = ReachTarget(env._pyrep, env._robot).target
    task = env.get_task(ReachTarget)
    task.reset()
    tip = env._robot.arm.get_tip().get_position()
    distance = np.linalg.norm(np.subtract(task._task.target.get_position(), tip))
    assert task._task.reward() == pytest.approx(-distance, abs=1e-6)
    assert [ball.get_name() for ball in task._task.distractors] == ["distractor0", "distractor1"]
    for name in ("nonsense", "boundary", "_nonsense"):
        assert not hasattr(task._task, name)


def test_conditions_can_be_asked_one_by_one(env: Environment) -> None:
    """`_success_conditions` says what of the goal is reached, for rewards of a program's own; a task may be got by its name."""
    task = env.get_task("pick_and_lift")
    task.reset()
    assert not any(condition.condition_met()[0] for condition in task._task._success_conditions)
    (demo,) = task.get_demos(1, live_demos=True)
    assert len(demo) > 10 and task._task._success_conditions
    assert all(condition.condition_met() == (True, False) for condition in task._task._success_conditions)
    assert task._task._graspable_objects == task._task.get_graspable_objects()
    with pytest.raises(RuntimeError, match="No task is called"):
        env.get_task("nonsense")


def test_a_path_knows_its_timing(env: Environment) -> None:
    """The trajectory of a planned path starts at the arm and ends at the last configuration."""
    _, start = env.get_task(ReachTarget).reset()
    path = env._robot.arm.get_path(start.gripper_pose[:3] - [0.0, 0.0, 0.1], quaternion=start.gripper_pose[3:])
    assert isinstance(path, ArmConfigurationPath) and path.trajectory is path.trajectory
    assert path.trajectory.duration > 0.1
