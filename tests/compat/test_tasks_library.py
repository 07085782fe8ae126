"""Tasks of the library under their known names: what they answer, and what a class made from one may change."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pyrep.const import PrimitiveShape
from pyrep.objects.shape import Shape
from rlbench import Environment, ObservationConfig
from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import JointVelocity
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.backend.task import Task, TreeChanged
from rlbench.backend.waypoints import Point, PredefinedPath
from rlbench.tasks import CloseMicrowave, OpenDrawer, OpenOven, ReachTarget, StackBlocks, TakeLidOffSaucepan, WipeDesk
from rlbench_pin.tasks import task_class
from tests.compat import paper_tasks

pytestmark = pytest.mark.simulation

MINE = """
from rlbench.tasks.open_drawer import OpenDrawer


class OnlyTheTop(OpenDrawer):

    def init_task(self):
        super().init_task()
        self.begun = 0

    def init_episode(self, index):
        self.begun += 1
        return [text.upper() for text in super().init_episode(2)]

    def variation_count(self):
        return 1

    def base_rotation_bounds(self):
        return (0.0, 0.0, -0.01), (0.0, 0.0, 0.01)


class AsItIs(OpenDrawer):
    pass
"""


@pytest.fixture(scope="module")
def environment() -> Iterator[Environment]:
    """An environment without images."""
    config = ObservationConfig()
    config.set_all_high_dim(False)
    env = Environment(MoveArmThenGripper(JointVelocity(), Discrete()), obs_config=config, headless=True)
    env.launch()
    yield env
    env.shutdown()


def test_what_a_task_answers(environment: Environment) -> None:
    """Waypoints with their texts, graspable objects, rotation bounds, success, low-dimensional state."""
    task = environment.get_task(TakeLidOffSaucepan)
    task.reset()
    user: Any = task._task
    assert isinstance(user, TakeLidOffSaucepan) and type(user.native) is task_class("take_lid_off_saucepan")
    waypoints = user.get_waypoints()
    assert [w.get_ext() for w in waypoints] == ["", "close_gripper()", "ignore_collision"]
    assert [w.get_waypoint_object().get_name() for w in waypoints] == ["waypoint0", "waypoint1", "waypoint2"]
    assert all(isinstance(w, Point) for w in waypoints)
    assert user.get_graspable_objects() == [Shape("lid")]
    assert user.success() == (False, False) and user.reward() < 0.0
    assert user.get_low_dim_state().shape == (14,)
    assert user.base_rotation_bounds() == ((0.0, 0.0, -3.14), (0.0, 0.0, 3.14)) and not user.is_static_workspace()
    assert user.boundary_root() == user.get_base()
    assert not user.should_repeat_waypoints()
    user.validate()


def test_paths_lead_to_waypoints(environment: Environment) -> None:
    """A path moves the tip to its waypoint; a curve is a path of its own kind."""
    task = environment.get_task(TakeLidOffSaucepan)
    task.reset()
    waypoint = task._task.get_waypoints()[0]
    assert len(waypoint.get_path(ignore_collisions=True)) > 1
    path = waypoint.get_path()
    for _ in range(400):
        if path.step():
            break
        environment._scene.step()
    tip = environment._robot.arm.get_tip().get_position()
    assert np.linalg.norm(tip - waypoint.get_waypoint_object().get_position()) < 0.01
    task = environment.get_task(CloseMicrowave)
    task.reset()
    kinds = [type(w) for w in task._task.get_waypoints()]
    curved = [w.path == "curve" for w in task._task.native.get_waypoints()]
    assert kinds == [PredefinedPath if curve else Point for curve in curved]


def _demonstrate(environment: Environment, user: Any) -> bool:
    """Play the waypoints by hand, as programs do that record demonstrations themselves."""
    gripper, step = environment._robot.gripper, environment._scene.step
    for point in user.get_waypoints():
        point.start_of_path()
        if point.skip:
            continue
        path, done = point.get_path(), False
        while not done:
            done = path.step()
            step()
        point.end_of_path()
        for key, full in (("open_gripper(", 1.0), ("close_gripper(", 0.0)):
            if key in point.get_ext():
                number = point.get_ext().partition(key)[2].partition(")")[0]
                if full:
                    gripper.release()
                while not gripper.actuate(float(number or full), 0.04):
                    step()
                for item in [] if full else user.get_graspable_objects():
                    gripper.grasp(item)
    return bool(user.success()[0])


@pytest.mark.parametrize("cls", [StackBlocks, WipeDesk, OpenOven])
def test_programs_play_waypoints_themselves(environment: Environment, cls: type[Task]) -> None:
    """Paths, texts and rounds of a task are enough to reach its goal: grasps, curves, partly open hands."""
    np.random.seed(1)
    task = environment.get_task(cls)
    user = task._task
    successes = []
    for _ in range(2):
        task.reset()
        success = _demonstrate(environment, user)
        while not success and user.should_repeat_waypoints():
            success = _demonstrate(environment, user)
        successes.append(success)
    assert any(successes)


def test_skip_and_functions_reach_the_task(environment: Environment) -> None:
    """`register_waypoint_ability_start` on a task of the library runs in demonstrations, and may leave a waypoint out."""
    task = environment.get_task(TakeLidOffSaucepan)
    called: list[str] = []

    def before(waypoint: Any) -> None:
        called.append(waypoint.name)
        waypoint.skip = True

    user = task._task
    user.register_stop_at_waypoint(2)
    assert len(user.get_waypoints()) == 2
    user.clear_registerings()
    assert user.get_graspable_objects() == []
    task = environment.get_task(TakeLidOffSaucepan)
    task._task.register_waypoint_ability_start(0, before)
    task._task.register_waypoint_ability_end(1, lambda waypoint: called.append(waypoint.name + " end"))
    assert len(task.get_demos(1, live_demos=True)[0]) > 10
    assert called[-2:] == ["waypoint0", "waypoint1 end"]
    assert [w.skip for w in task._task.get_waypoints()] == [True, False, False]


def test_tree_goes_back(environment: Environment) -> None:
    """`get_state` and `restore_state` hold objects and joints; other objects than before are refused."""
    task = environment.get_task(OpenDrawer)
    task.reset()
    user = task._task
    state, before = user.get_state(), user.get_low_dim_state()
    environment._scene.runtime.world.joint("chest/drawer_top").set_position(0.1)
    user.get_base().set_position([0.4, 0.1, 0.8])
    assert not np.allclose(user.get_low_dim_state(), before)
    user.restore_state(state)
    assert np.allclose(user.get_low_dim_state(), before)
    Shape.create(PrimitiveShape.CUBOID, [0.02, 0.02, 0.02], position=[0.2, 0.3, 0.9])
    with pytest.raises(TreeChanged, match="had 1 objects and has 2 now"):
        user.restore_state(state)


def test_a_class_made_from_one_of_the_library(environment: Environment, tmp_path: Path) -> None:
    """It overrides single methods and calls the rest; scene and goal are those of the library."""
    module = paper_tasks.write_task(tmp_path, "drawers_of_mine", MINE, "")
    (tmp_path / "drawers_of_mine.toml").unlink()
    task = environment.get_task(module.OnlyTheTop)
    assert (task.get_name(), task.variation_count()) == ("only_the_top", 1)
    descriptions, _ = task.reset()
    assert descriptions[0] == "PULL OUT THE TOP DRAWER." and task._task.begun >= 1
    assert isinstance(task._task.native, task_class("open_drawer"))
    quaternion = task._task.get_base().get_quaternion()
    assert abs(2.0 * np.arcsin(quaternion[2])) <= 0.0101
    demo = task.get_demos(1, live_demos=True)[0]
    assert len(demo) > 10 and environment._scene.runtime.world.joint("chest/drawer_top").position > 0.15
    task = environment.get_task(module.AsItIs)
    assert (task.get_name(), task.variation_count()) == ("as_it_is", 3)
    assert task.reset()[0][0] == "Pull out the bottom drawer."


def test_episodes_of_the_library_repeat(environment: Environment) -> None:
    """The known habit of seeding numpy's global generator repeats episodes; `init_episode` may be called alone."""
    task = environment.get_task(StackBlocks)
    states = []
    for _ in range(2):
        np.random.seed(4)
        task.set_variation(0)
        task.reset()
        states.append(task._task.get_low_dim_state())
    assert np.array_equal(*states)
    assert "red" in task._task.init_episode(0)[0]


def test_unloading(environment: Environment) -> None:
    """The table is empty afterwards, and a task that is not loaded says so; `load` alone builds its world."""
    task = environment.get_task(ReachTarget)
    user: Any = task._task
    user.unload()
    assert not Shape.exists("target")
    user = ReachTarget(environment._pyrep, environment._robot)
    assert user.load() == user.get_base() and Shape.exists("target")
    user.unload()
