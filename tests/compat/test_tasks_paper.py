"""Task files in the paper's style run: demonstrations, variations, random draws, conditions, hooks, states."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rlbench import Environment, ObservationConfig
from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import JointPosition
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.backend.conditions import FollowCondition, JointCondition, OrConditions
from rlbench.backend.task import Task
from rlbench_pin.errors import TaskError
from rlbench_pin.tasks import LIBRARY
from tests.compat import paper_tasks

pytestmark = pytest.mark.simulation


@pytest.fixture(scope="module")
def environment() -> Iterator[Environment]:
    """An environment without images."""
    config = ObservationConfig()
    config.set_all_high_dim(False)
    config.task_low_dim_state = True
    env = Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=config, headless=True)
    env.launch()
    yield env
    env.shutdown()


@pytest.fixture(scope="module")
def classes(tmp_path_factory: pytest.TempPathFactory) -> dict[str, type[Task]]:
    """The three task files of `paper_tasks`, read from a folder."""
    folder = tmp_path_factory.mktemp("tasks")
    drawer = (LIBRARY / "open_drawer.toml").read_text()
    drawer = drawer.replace('name = "waypoint1"', 'name = "waypoint1"\nparent = "chest"')
    lid = paper_tasks.write_task(folder, "lift_the_lid", paper_tasks.LID, paper_tasks.LID_SCENE)
    cubes = paper_tasks.write_task(folder, "cubes_of_mine", paper_tasks.CUBES, paper_tasks.CUBES_SCENE)
    pull = paper_tasks.write_task(folder, "pull_a_drawer", paper_tasks.DRAWER, drawer)
    return {"lid": lid.LiftTheLid, "cubes": cubes.CubeToPlate, "drawer": pull.PullADrawer}


def replayed(task: Any, demo: Any) -> bool:
    """Whether the recorded joint positions of a demonstration reach the goal again."""
    task.reset_to_demo(demo)
    terminate = False
    for observation in demo[1:]:
        _, reward, terminate = task.step(observation.misc["joint_position_action"])
        if terminate:
            return bool(reward == 1.0)
    return terminate


def test_the_lid_comes_off(environment: Environment, classes: dict[str, type[Task]]) -> None:
    """Two demonstrations succeed, replay, and begin at different places."""
    np.random.seed(0)
    task = environment.get_task(classes["lid"])
    assert task.get_name() == "lift_the_lid" and task.variation_count() == 1
    demos = task.get_demos(2, live_demos=True)
    assert all(len(demo) > 20 for demo in demos)
    assert not np.allclose(demos[0][0].task_low_dim_state, demos[1][0].task_low_dim_state)
    assert replayed(task, demos[0])
    user = task._task
    assert user.success() == (True, True)
    assert [item.get_name() for item in user.get_graspable_objects()] == ["lid"]
    assert [item.get_name() for item in environment._robot.gripper.get_grasped_objects()] == ["lid"]
    assert user.reward() <= 0.0


def test_what_a_task_draws_repeats_with_the_seed(environment: Environment, classes: dict[str, type[Task]]) -> None:
    """Same global seed, same colours, places and draws; nobody else's draws are touched by laying out an episode."""
    task = environment.get_task(classes["cubes"])
    assert task.variation_count() == 20
    seen = []
    for _ in range(2):
        np.random.seed(5)
        task.set_variation(3)
        descriptions, first = task.reset()
        seen.append((descriptions, first.task_low_dim_state, [c.get_color() for c in task._task.others], np.random.rand()))
    assert seen[0][0] == seen[1][0] == ["put the green cube on the plate", "the green block belongs onto the plate"]
    assert np.array_equal(seen[0][1], seen[1][1]) and seen[0][2] == seen[1][2] and seen[0][3] == seen[1][3]
    assert first.misc["goal_color"][:3] == pytest.approx((0.0, 0.5, 0.0))
    other = task.reset()[1]
    assert not np.allclose(other.task_low_dim_state, first.task_low_dim_state)
    places = np.array([item.get_position() for item in [task._task.cube, *task._task.others]])
    gaps = np.linalg.norm(places[:, None] - places[None], axis=-1) + np.eye(3)
    assert gaps.min() >= 0.08


def test_cubes_are_demonstrated_and_hooks_draw(environment: Environment, classes: dict[str, type[Task]]) -> None:
    """A start function sees the waypoint; its draws repeat when the demonstration's seed does."""
    task = environment.get_task(classes["cubes"])
    task.set_variation(1)
    notes = []
    for _ in range(2):
        np.random.seed(11)
        demo = task.get_demos(1, live_demos=True)[0]
        notes.append((demo[0].task_low_dim_state.tolist(), list(task._task.notes)))
    assert notes[0] == notes[1]
    assert notes[0][1][0][0] == "waypoint0"
    assert replayed(task, demo)


def test_a_state_brings_attributes_back(environment: Environment, classes: dict[str, type[Task]]) -> None:
    """`save` and `restore` of the runtime hold what the user's task keeps, and what its conditions count."""
    task = environment.get_task(classes["drawer"])
    task.set_variation(2)
    task.reset()
    user = task._task
    runtime = environment._scene.runtime
    for _ in range(3):
        runtime.step()
    steps, state = user.steps, runtime.save()
    user.moved.condition_met()
    asked = user.moved.asked
    runtime.step()
    user.joints.append("x")
    runtime.restore(state)
    assert (user.steps, len(user.joints), user.moved.asked) == (steps, 3, asked - 1)


def test_drawer_with_conditions_of_its_own(environment: Environment, classes: dict[str, type[Task]]) -> None:
    """Joint, follow, or and a user's condition; a root of its own for random placement; step and cleanup run."""
    np.random.seed(2)
    task = environment.get_task(classes["drawer"])
    for variation in range(3):
        task.set_variation(variation)
        demo = task.get_demos(1, live_demos=True)[0]
        assert len(demo) > 10 and task._task.steps > 10
        joints = [joint.get_joint_position() for joint in task._task.joints]
        assert int(np.argmax(joints)) == variation and max(joints) > 0.15
    assert task._task.cleaned
    places = set()
    for _ in range(3):
        task.reset()
        places.add(tuple(task._task.boundary_root().get_position().round(4)))
    assert len(places) == 3
    assert task._task.get_base().get_position() == pytest.approx(environment._scene.runtime.world.root.position)


def test_conditions_ask_views(environment: Environment, classes: dict[str, type[Task]]) -> None:
    """A followed path with strikes, a joint's travel since the condition was made, and one of several."""
    task = environment.get_task(classes["drawer"])
    task.reset()
    joint, chest = task._task.joints[0], task._task.boundary_root()
    here = chest.get_position()
    moved = JointCondition(joint, 0.1)
    assert moved.condition_met() == (False, False)
    joint.set_joint_position(0.12, disable_dynamics=True)
    assert moved.condition_met() == (True, True)
    assert OrConditions([JointCondition(joint, 0.1), moved]).condition_met() == (True, True)
    follow = FollowCondition(chest, [here, here + [0.0, 0.0, 0.5]])
    assert [follow.condition_met() for _ in range(6)] == [(False, False)] * 5 + [(False, True)]
    follow.reset()
    assert (follow.index, follow.strikes) == (0, 0)
    near = FollowCondition(chest, [[0.0, 0.0, 0.0]], relative_to=chest)
    assert near.condition_met() == (True, True)


def test_a_task_without_a_scene_says_where_it_looked(environment: Environment, tmp_path: Path) -> None:
    """A model file of another simulator beside the module is named."""
    module = paper_tasks.write_task(tmp_path, "lone_task", paper_tasks.LID.replace("LiftTheLid", "LoneTask"), "")
    (tmp_path / "lone_task.toml").rename(tmp_path / "lone_task.ttm")
    with pytest.raises(FileNotFoundError, match="lone_task.ttm.*cannot be read") as caught:
        environment.get_task(module.LoneTask)
    assert str(tmp_path / "lone_task.toml") in str(caught.value)
    user = module.LoneTask(None, None)
    with pytest.raises(TaskError, match="'lone_task' is not loaded"):
        user.get_waypoints()
    for call in (Task.init_task, Task.variation_count):
        with pytest.raises(NotImplementedError, match="must define"):
            call(Task(None, None))  # type: ignore[arg-type]
