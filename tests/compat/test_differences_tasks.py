"""What differs in observations, tasks, stored demonstrations and gymnasium under the known names; rows of the page."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from pyrep.const import PrimitiveShape
from pyrep.errors import PyRepError
from pyrep.objects import Dummy, Shape
from rlbench import Environment, ObservationConfig
from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import EndEffectorPoseViaPlanning, JointVelocity
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.backend.conditions import ColorCondition, FollowCondition
from rlbench.backend.exceptions import InvalidActionError
from rlbench.backend.observation import Observation
from rlbench.backend.task_utils import sample_procedural_objects
from rlbench.dataset_generator import save_demo
from rlbench.demo import Demo
from rlbench.gym import RLBenchEnv
from rlbench.noise_model import GaussianNoise
from rlbench.task_environment import TaskEnvironment
from rlbench.tasks import OpenDrawer, ReachTarget, TakeLidOffSaucepan
from rlbench_pin.assets import asset_path
from rlbench_pin.errors import AssetNotFound
from rlbench_pin.gym.environment import WindowMissing
from tests.compat import paper_tasks

REMEMBERING = """
import numpy as np
from pyrep.objects.shape import Shape
from rlbench.backend.conditions import NothingGrasped
from rlbench.backend.task import Task


class Remembering(Task):

    def init_task(self):
        self.calls = ['init_task']
        self.register_success_conditions([NothingGrasped(self.robot.gripper)])

    def init_episode(self, index):
        self.calls.append('init_episode')
        self.draw = np.random.rand()
        return ['lift it', 'lift it', 'raise it']

    def variation_count(self):
        return 1
"""


def low_dim() -> ObservationConfig:
    """All low-dimensional data, no images."""
    config = ObservationConfig()
    config.set_all_high_dim(False)
    config.set_all_low_dim(True)
    return config


@pytest.fixture(scope="module")
def environment() -> Iterator[Environment]:
    """An environment without images."""
    with Environment(MoveArmThenGripper(JointVelocity(), Discrete()), obs_config=low_dim()) as environment:
        yield environment


@pytest.fixture
def task(environment: Environment) -> TaskEnvironment:
    """The reach task."""
    return environment.get_task(ReachTarget)


@pytest.fixture
def scene(task: TaskEnvironment) -> Any:
    """The scene of a fresh episode of it."""
    task.reset()
    return task._scene


# Observations -----------------------------------------------------------------------------------------------------------


def test_forces_do_not_depend_on_the_direction_of_motion(scene: Any) -> None:
    """The shoulder holds the arm against gravity with a negative torque, moving up or down."""
    forces = []
    for velocity in (0.05, -0.05):
        JointVelocity().action(scene, [0, velocity, 0, 0, 0, 0, 0])
        forces.append(scene.get_observation().joint_forces[1])
    assert max(forces) < -10.0


def test_noise_leaves_its_argument() -> None:
    """A program that keeps the array keeps the true values."""
    true = np.zeros(4)
    assert GaussianNoise(0.1).apply(true).std() > 0.0 and not true.any()


def test_a_camera_matrix_is_in_misc(scene: Any) -> None:
    """Where the flag asks for it."""
    assert scene.get_observation().misc["wrist_camera_matrix"].shape == (4, 4)
    scene._obs_config.wrist_camera_matrix = False
    assert "wrist_camera_matrix" not in scene.get_observation().misc
    scene._obs_config.wrist_camera_matrix = True


def test_the_first_frame_is_the_start(task: TaskEnvironment) -> None:
    """No step is taken before it."""
    np.random.seed(4)
    _, start = task.reset()
    demo = task._scene.get_demo()
    assert np.array_equal(demo[0].joint_positions, start.joint_positions)  # type: ignore[arg-type]
    assert np.array_equal(demo[0].task_low_dim_state, start.task_low_dim_state)  # type: ignore[arg-type]


def test_a_flag_for_collisions_can_be_left_out(task: TaskEnvironment) -> None:
    """It is on every frame otherwise."""
    assert {frame.ignore_collisions for frame in task.get_demos(1, live_demos=True)[0]} <= {True, False}
    task._obs_config.record_ignore_collisions = False
    assert {frame.ignore_collisions for frame in task.get_demos(1, live_demos=True)[0]} == {None}
    task._obs_config.record_ignore_collisions = True


# Tasks ------------------------------------------------------------------------------------------------------------------


def test_a_task_begins_when_it_is_loaded(environment: Environment, tmp_path: Path) -> None:
    """Before the first reset; a sentence that is said twice is said once, and its draws are the episode's."""
    module = paper_tasks.write_task(tmp_path, "remembering", REMEMBERING, paper_tasks.LID_SCENE)
    task: Any = environment.get_task(module.Remembering)
    assert task._task.calls == ["init_task"]
    draws = []
    for seed in (7, 7, 8):
        np.random.seed(seed)
        np.random.randint(2**31)
        expected = np.random.rand()
        np.random.seed(seed)
        descriptions, _ = task.reset()
        assert descriptions == ["lift it", "raise it"] and np.random.rand() == expected
        draws.append(task._task.draw)
    assert draws[0] == draws[1] != draws[2]


def test_the_default_state_holds_bodies_and_joints(environment: Environment) -> None:
    """One body with three drawers; dummies, waypoints, sensors and links are objects of the tree, and not in the state."""
    task: Any = environment.get_task(OpenDrawer)
    task.reset()
    tree = task._task.get_base().get_objects_in_tree()
    assert len(tree) > 8 and {type(item).__name__ for item in tree} >= {"Shape", "Joint", "Dummy"}
    assert task._task.get_low_dim_state().shape == (7 + 3,)


def test_shapes_made_later_are_not_in_the_default_state(environment: Environment) -> None:
    """Its length stays, whatever is made, and whatever is set as initial."""
    task: Any = environment.get_task(OpenDrawer)
    task.reset()
    before = task._task.get_low_dim_state()
    Shape.create(PrimitiveShape.CUBOID, [0.04] * 3, static=True, position=[0.3, 0.3, 1.2]).set_parent(task._task.get_base())
    task._task.set_initial_objects_in_scene()
    assert np.array_equal(task._task.get_low_dim_state(), before)


def test_switches_and_masses_stay(environment: Environment) -> None:
    """Through resets; a colour does not."""
    task = environment.get_task(TakeLidOffSaucepan)
    task.reset()
    lid = Shape("lid")
    color, mass = lid.get_color(), lid.get_mass()
    lid.set_color([0.1, 0.9, 0.1])
    lid.set_mass(2.0 * mass)
    lid.set_bullet_friction(0.31)
    lid.set_detectable(False)
    lid.set_collidable(False)
    task.reset()
    assert lid.get_color() == pytest.approx(color) and lid.get_mass() == pytest.approx(2.0 * mass)
    assert lid.get_bullet_friction() == pytest.approx(0.31) and not lid.is_detectable() and not lid.is_collidable()
    assert environment.get_task(TakeLidOffSaucepan) and Shape("lid").get_mass() == pytest.approx(mass)


def test_points_are_visited_within_half_of_the_limit(scene: Any) -> None:
    """Between half and all of it a point is neither visited nor missed."""
    mark = Dummy.create()
    outcomes = {}
    for distance in (0.004, 0.007, 0.02):
        follow = FollowCondition(mark, [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0]], delta_limit=0.01, start_after_first=False)
        mark.set_position([distance, 0.0, 1.0])
        outcomes[distance] = [follow.condition_met() for _ in range(6)][-1]
    assert outcomes == {0.004: (True, True), 0.007: (False, False), 0.02: (False, True)}
    mark.remove()


def test_colours_can_be_asked_for(scene: Any) -> None:
    """Met by exactly that colour."""
    target = Shape("target")
    target.set_color([0.25, 0.5, 1.0])
    assert ColorCondition(target, (0.25, 0.5, 1.0)).condition_met() == (True, True)
    assert ColorCondition(target, (0.25, 0.5, 0.9)).condition_met() == (False, False)


def test_procedural_objects_are_solids_of_this_package(environment: Environment) -> None:
    """In several sizes, with the mass that was asked for."""
    task: Any = environment.get_task(OpenDrawer)
    task.reset()
    np.random.seed(0)
    shapes = sample_procedural_objects(task._task.get_base(), 3, mass=0.2)
    spawned = task.runtime.world.spawned
    files = [asset_path(spawned[shape.element.name].asset) for shape in shapes]
    assert all(file.parent.name == "convex" for file in files) and len({spec.scale for spec in spawned.values()}) == 3
    assert [shape.get_mass() for shape in shapes] == pytest.approx([0.2] * 3)


def test_waypoints_stay(environment: Environment) -> None:
    """They are part of the scene file."""
    task: Any = environment.get_task(TakeLidOffSaucepan)
    task.reset()
    with pytest.raises(PyRepError, match="scene file"):
        task._task.get_waypoints()[0].remove()
    assert len(task._task.get_waypoints()) == 3


def test_a_waypoint_that_closes_a_little_says_so(environment: Environment, tmp_path: Path) -> None:
    """To seven tenths, from open."""
    scene = paper_tasks.LID_SCENE.replace('gripper = "close"', "gripper = 0.7")
    assert scene != paper_tasks.LID_SCENE
    module = paper_tasks.write_task(tmp_path, "lift_the_lid", paper_tasks.LID, scene)
    task: Any = environment.get_task(module.LiftTheLid)
    words = [waypoint.get_ext() for waypoint in task._task.get_waypoints()]
    assert "close_gripper(0.7)" in words and not any("open_gripper" in word for word in words)


def test_placing_a_demo_has_no_effect(task: TaskEnvironment) -> None:
    """The same seed gives the same episode with the flag and without."""
    states = []
    for flag in (False, True):
        np.random.seed(6)
        task._scene.reset()
        task._scene.init_episode(0, max_attempts=10, place_demo=flag)
        states.append(task._task.get_low_dim_state())
    assert np.array_equal(*states)


# Data and gymnasium -----------------------------------------------------------------------------------------------------


def test_made_shapes_come_back_where_their_files_are(environment: Environment) -> None:
    """A snapshot names the model file; without it the error does."""
    task = environment.get_task(OpenDrawer)
    task.reset()
    world = task.runtime.world
    shape = Shape.create(PrimitiveShape.CUBOID, [0.0123, 0.0234, 0.0345], position=[0.3, 0.3, 1.2])
    file, snapshot = Path(world.spawned[shape.element.name].asset), world.arrays()
    task.reset()
    world.set_arrays(snapshot)
    assert len(world.spawned) == 1
    task.reset()
    moved = file.rename(file.with_suffix(".elsewhere"))
    try:
        with pytest.raises(AssetNotFound, match=file.name):
            world.set_arrays(snapshot)
    finally:
        moved.rename(file)


def test_a_pickled_demo_names_our_classes(tmp_path: Path) -> None:
    """Written by hand; what is exported names those of RLBench."""
    demo = Demo([Observation(joint_positions=np.zeros(7))], random_seed=3)
    assert b"rlbench_pin.observation" in pickle.dumps(demo)
    save_demo(demo, tmp_path)
    exported = (tmp_path / "low_dim_obs.pkl").read_bytes()
    assert b"rlbench.demo" in exported and b"rlbench_pin" not in exported


def test_the_same_seed_gives_the_same_episode_in_gymnasium() -> None:
    """Flagged otherwise or not; a refused action raises; `info` says what there is."""
    environment = RLBenchEnv(ReachTarget, action_mode=MoveArmThenGripper(EndEffectorPoseViaPlanning(), Discrete()))
    starts = [environment.reset(seed=3)[0]["task_low_dim_state"] for _ in range(2)]
    assert np.array_equal(*starts)
    assert gymnasium.spec("rlbench/reach_target-state-v0").nondeterministic
    with pytest.raises(InvalidActionError):
        environment.step(np.array([9.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 1.0]))
    assert set(environment.reset()[1]) == {"text_descriptions", "success", "is_success", "variation"}
    environment.close()


def test_a_window_needs_a_screen(monkeypatch: pytest.MonkeyPatch) -> None:
    """The error says so before anything starts."""
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(WindowMissing, match="rgb_array"):
        RLBenchEnv(ReachTarget, render_mode="human")
