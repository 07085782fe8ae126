"""The base class of all tasks."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from rlbench_pin.errors import TaskError, UnknownName
from rlbench_pin.robot.description import robot_description
from rlbench_pin.scene.spec import BodySpec, JointSpec, PlacementSpec, SceneSpec, WaypointSpec
from rlbench_pin.sim import World
from rlbench_pin.spatial import TABLE_HEIGHT
from rlbench_pin.tasks import InOrder, JointMoved, ListEmpty, Task

SCENE = SceneSpec(
    format=1,
    placement=PlacementSpec(pose=(0.4, 0.0, TABLE_HEIGHT, 0, 0, 0, 1), yaw=(-0.3, 0.3)),
    body=(
        BodySpec(name="cube", asset="objects/cube/cube.urdf", pose=(-0.3, 0.0, 0.025, 0, 0, 0, 1)),
        BodySpec(name="chest", asset="objects/chest/chest.urdf", fixed=True),
    ),
    joint=(JointSpec(name="chest/drawer_top"),),
    waypoint=tuple(WaypointSpec(name=f"waypoint{i}", gripper=g) for i, g in enumerate((0.5, "close", None, "open"))),
)


class Chore(Task):
    """Has a list, a counter, and a drawer to pull."""

    def init_task(self) -> None:
        self.todo = ["a", "b"]
        self.pulled = InOrder([JointMoved(self.world.joint("chest/drawer_top"), 0.1)])
        self.cleaned = 0
        self.register_graspable_objects(["cube"])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        self.count = variation
        self.register_success_conditions([ListEmpty(self.todo), self.pulled])
        return [f"Do {variation}.", f"Please do {variation}."]

    def variation_count(self) -> int:
        return 3

    def cleanup(self) -> None:
        self.cleaned += 1


@pytest.fixture
def task() -> Iterator[Chore]:
    """A chore in its own world, set up."""
    with World(SCENE, robot_description("panda")) as world:
        chore = Chore(world)
        chore.init_task()
        yield chore


def rng() -> np.random.Generator:
    """A generator whose seed does not matter."""
    return np.random.default_rng(0)


def test_success_needs_all_conditions_at_once(task: Chore) -> None:
    """Plain bools come back; success also ends the episode."""
    task.begin_episode(0, rng())
    assert task.success() == (False, False)
    task.world.joint("chest/drawer_top").set_position(0.2)
    assert task.success() == (False, False)
    task.todo.clear()
    assert task.success() == (True, True)
    assert all(type(flag) is bool for flag in task.success())


def test_stateful_conditions_see_every_evaluation(task: Chore) -> None:
    """A later condition counts on while an earlier one does not hold."""
    task.begin_episode(0, rng())
    joint = task.world.joint("chest/drawer_top")
    joint.set_position(0.2)
    task.success()
    joint.set_position(0.0)
    task.todo.clear()
    assert task.success() == (True, True)


def test_an_empty_success_list_is_a_mistake(task: Chore) -> None:
    """It would otherwise always hold."""
    with pytest.raises(TaskError, match="'chore' registers no success condition"):
        task.success()


def test_the_fail_list_comes_first_and_needs_all_its_members(task: Chore) -> None:
    """Then the episode ends without success."""
    task.begin_episode(0, rng())
    task.register_success_conditions([ListEmpty([])])
    todo = [1]
    task.register_fail_conditions([ListEmpty([]), ListEmpty(todo)])
    assert task.success() == (True, True)
    todo.clear()
    assert task.success() == (False, True)


def test_resetting_conditions_starts_from_now(task: Chore) -> None:
    """What moved before does not count."""
    task.begin_episode(0, rng())
    task.todo.clear()
    task.world.joint("chest/drawer_top").set_position(0.2)
    assert task.success() == (True, True)
    task.reset_conditions()
    assert task.success() == (False, False)


@pytest.mark.parametrize("instructions", [[], ["same", "same"], [" "], ("a",), "a sentence", [1], None])
def test_instructions_are_a_list_of_different_sentences(task: Chore, instructions: object) -> None:
    """Anything else is refused at once."""
    task.init_episode = lambda variation, rng: instructions  # type: ignore[method-assign, assignment]
    with pytest.raises(TaskError, match="must return a list of different sentences"):
        task.begin_episode(0, rng())


@pytest.mark.parametrize("variation", [-1, 3])
def test_a_variation_that_does_not_exist_is_refused(task: Chore, variation: int) -> None:
    """The message says which exist."""
    with pytest.raises(TaskError, match="Choose 0 to 2"):
        task.begin_episode(variation, rng())


def test_cleanup_runs_once_after_each_episode(task: Chore) -> None:
    """And not before the first."""
    task.end_episode()
    assert task.cleaned == 0
    task.begin_episode(0, rng())
    task.end_episode()
    task.end_episode()
    assert task.cleaned == 1


def test_state_brings_everything_back(task: Chore) -> None:
    """Attributes, lists that conditions share, pointers, registrations and skips."""
    task.begin_episode(1, rng())
    task.world.joint("chest/drawer_top").set_position(0.2)
    task.todo.pop()
    task.success()
    task.get_waypoints()[1].skip = True
    world, state, todo = task.world.save(), task.state(), task.todo

    task.end_episode()
    task.begin_episode(2, rng())
    task.register_success_conditions([ListEmpty([])])
    task.register_graspable_objects([])
    task.todo.clear()
    task.extra = 1  # type: ignore[attr-defined]

    task.world.restore(world)
    task.set_state(state)
    assert (task.count, task.todo, task.cleaned, task.pulled.passed) == (1, ["a"], 0, 1)
    assert task.todo is todo
    assert not hasattr(task, "extra")
    assert task.world.body("cube").graspable
    assert task.get_waypoints()[1].skip
    assert task.success() == (False, False)
    task.todo.clear()
    assert task.success() == (True, True)
    task.set_state(state)
    assert task.todo == ["a"]


def test_graspable_bodies_are_marked_and_replaced(task: Chore) -> None:
    """An unknown name is refused and changes nothing."""
    assert task.get_graspable_objects() == ("cube",)
    with pytest.raises(UnknownName, match="Did you mean 'chest'"):
        task.register_graspable_objects(["chst"])
    assert task.world.body("cube").graspable
    task.register_graspable_objects(["chest"])
    assert not task.world.body("cube").graspable
    assert task.world.body("chest").graspable
    task.register_graspable_objects(["chest/drawer_top_link", "chest/drawer_middle_link"])
    assert task.get_graspable_objects() == ("chest",)
    assert task.world.body("chest").grasp_links == ("drawer_top_link", "drawer_middle_link")
    with pytest.raises(UnknownName, match="No link of body 'chest' is called 'drawer_tip_link'. Did you mean 'drawer_top_link'"):
        task.register_graspable_objects(["chest/drawer_tip_link"])
    task.register_graspable_objects(["chest"])
    assert task.world.body("chest").grasp_links == ()


def test_waypoints_come_in_order_and_stop_where_registered(task: Chore) -> None:
    """What the gripper does is known from the order; skips are cleared by the next episode."""
    points = task.get_waypoints()
    assert [w.index for w in points] == [0, 1, 2, 3]
    assert [w.gripper_amount for w in points] == [0.5, 0.0, 0.0, 1.0]
    assert [w.releases for w in points] == [False, False, False, True]
    points[2].skip = True
    task.begin_episode(0, rng())
    assert not points[2].skip
    task.register_stop_at_waypoint(2)
    assert task.get_waypoints() == points[:2]
    with pytest.raises(TaskError, match="no waypoint 4; its scene has 4"):
        task.register_stop_at_waypoint(4)


def test_hooks_and_repeat_are_called(task: Chore) -> None:
    """Each call of a register function replaces what was there, start and end apart."""
    calls: list[str] = []
    task.register_waypoint_ability_start(1, lambda w: calls.append("old"))
    task.register_waypoint_ability_start(1, lambda w: calls.append(f"start {w.index}"))
    task.register_waypoint_ability_end(1, lambda w: calls.append("end"))
    task.get_waypoints()[1].run_start_hook()
    task.get_waypoints()[1].run_end_hook()
    assert calls == ["start 1", "end"]
    assert not task.should_repeat_waypoints()
    task.register_waypoints_should_repeat(lambda: True)
    assert task.should_repeat_waypoints()


def test_rounds_are_counted_and_come_back_with_the_state(task: Chore) -> None:
    """The waypoints are played that many times; registering begins again."""
    assert not task.repeats_waypoints
    task.register_rounds(3)
    assert task.repeats_waypoints
    assert (task.round, task.should_repeat_waypoints(), task.round) == (0, True, 1)
    state = task.state()
    assert [task.should_repeat_waypoints() for _ in range(2)] == [True, False]
    task.set_state(state)
    assert task.round == 1
    task.register_rounds(1)
    assert task.round == 0
    assert not task.should_repeat_waypoints()


def test_the_defaults_come_from_the_scene_file(task: Chore) -> None:
    """Rotation bounds, static workspace, no reward, observations as they are."""
    assert task.base_rotation_bounds() == ((0.0, 0.0, -0.3), (0.0, 0.0, 0.3))
    assert task.is_static_workspace() is False
    assert task.reward() is None
    marker = object()
    assert task.decorate_observation(marker) is marker  # type: ignore[arg-type, comparison-overlap]


def test_the_default_low_dim_state_is_poses_then_joints_by_name(task: Chore) -> None:
    """Its layout is fixed by the scene file."""
    task.world.joint("chest/drawer_middle").set_position(0.1)
    state = task.get_low_dim_state()
    assert state.shape == (2 * 7 + 3,)
    np.testing.assert_allclose(state[:7], task.world.body("chest").pose)
    np.testing.assert_allclose(state[7:14], task.world.body("cube").pose)
    np.testing.assert_allclose(state[14:], [0.0, 0.1, 0.0], atol=1e-12)
    del task.world.bodies["cube"]
    assert not task.get_low_dim_state()[7:14].any()
