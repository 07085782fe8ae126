"""What a task saves with the world, and what it refuses to keep."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
import pytest

from rlbench_pin.errors import TaskError
from rlbench_pin.robot.description import robot_description
from rlbench_pin.scene.spec import BodySpec, RegionSpec, SceneSpec, SensorSpec, WaypointSpec
from rlbench_pin.sim import World
from rlbench_pin.tasks import InOrder, JointMoved, ListEmpty, SpawnBoundary, Task

SCENE = SceneSpec(
    format=1,
    body=(BodySpec(name="chest", asset="objects/chest/chest.urdf", pose=(0.2, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0), fixed=True),),
    region=(RegionSpec(name="patch", size=(0.2, 0.2, 0.0)),),
    sensor=(SensorSpec(name="goal", shape="sphere", size=(0.1,)),),
    waypoint=(WaypointSpec(name="waypoint0"),),
)


class Keeper(Task):
    """Keeps whatever a test gives it."""

    def init_task(self) -> None:
        self.register_success_conditions([ListEmpty([1])])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        return ["Keep it."]


class Counter:
    """An object of a task file that says what it remembers."""

    def __init__(self) -> None:
        self.count = 0

    def state(self) -> int:
        return self.count

    def set_state(self, state: int) -> None:
        self.count = state


class Silent:
    """An object of a task file that does not."""


@dataclass
class Loose:
    """A record that may change."""

    count: int = 0


@dataclass(frozen=True)
class Record:
    """A record whose fields stay, but not what one of them holds."""

    items: list[int] = field(default_factory=list)


@pytest.fixture
def task() -> Iterator[Any]:
    """A task in its world, set up."""
    with World(SCENE, robot_description("panda")) as world:
        keeper = Keeper(world)
        keeper.init_task()
        yield keeper


@pytest.mark.parametrize(
    "value", [None, True, 2, 0.5, "word", b"raw", 1j, np.float64(3.0), range(3), ("a", (1, 2)), frozenset({1})]
)
def test_plain_values_come_back(task: Any, value: object) -> None:
    """An attribute that was given another value gets the old one."""
    task.kept = value
    state = task.state()
    task.kept = "other"
    task.set_state(state)
    assert task.kept is value


def test_a_hook_may_be_a_partial_function(task: Any) -> None:
    """Two waypoints can share one method that is given different arguments."""
    calls: list[int] = []
    task.register_waypoint_ability_start(0, partial(lambda number, waypoint: calls.append(number), 3))
    task.begin_episode(0, np.random.default_rng(0))
    task.set_state(task.state())
    task.get_waypoints()[0].run_start_hook()
    assert calls == [3]


def test_containers_keep_their_identity_at_every_depth(task: Any) -> None:
    """Whoever shares a list inside a dict inside a tuple sees its old contents."""
    inner, members, array = [1, 2], {"a"}, np.arange(3.0)
    task.kept = ({"inner": inner, "members": members}, [array])
    state = task.state()
    inner.append(3)
    members.clear()
    array[:] = 0.0
    task.kept[0]["more"] = 1
    task.set_state(state)
    assert task.kept[0] == {"inner": [1, 2], "members": {"a"}}
    assert task.kept[0]["inner"] is inner
    assert task.kept[1][0] is array
    np.testing.assert_array_equal(array, [0.0, 1.0, 2.0])


def test_a_frozen_record_is_looked_into(task: Any) -> None:
    """Its list is saved."""
    task.kept = Record([1])
    state = task.state()
    task.kept.items.clear()
    task.set_state(state)
    assert task.kept.items == [1]


def test_what_the_world_hands_out_is_kept_as_it_is(task: Any) -> None:
    """Bodies, joints, frames, regions, sensors and waypoints."""
    world = task.world
    task.kept = [
        world.body("chest"),
        world.joint("chest/drawer_top"),
        world.root,
        world.region("patch"),
        world.sensor("goal"),
        task.get_waypoints()[0],
        task.gripper,
        task.robot,
    ]
    before = list(task.kept)
    state = task.state()
    task.kept.clear()
    task.set_state(state)
    assert all(a is b for a, b in zip(task.kept, before, strict=True))


def test_objects_with_state_are_saved_wherever_they_are(task: Any) -> None:
    """Those of a task file, conditions that are not registered, the draws of a boundary, in a list as well."""
    joint = task.world.joint("chest/drawer_top")
    task.counter, task.boundary = Counter(), SpawnBoundary([task.world.region("patch")])
    task.conditions = [InOrder([JointMoved(joint, 0.1)])]
    task.boundary.sample(task.world.frame("root"), np.random.default_rng(0))
    state, placed = task.state(), task.boundary.state()
    assert len(placed) == 1
    task.counter.count = 7
    task.boundary.clear()
    joint.set_position(0.2)
    assert task.conditions[0].met()
    task.set_state(state)
    assert task.counter.count == 0
    assert task.boundary.state() == placed
    assert task.conditions[0].passed == 0


@pytest.mark.parametrize(
    ("value", "kind", "where"),
    [
        (Silent(), "Silent", "self.kept,"),
        ([1, Silent()], "Silent", r"self.kept\[1\],"),
        ({"a": (Loose(),)}, "Loose", r"self.kept\['a'\]\[0\],"),
        (Record([Silent()]), "Silent", r"self.kept.items\[0\],"),  # type: ignore[list-item]
        (np.random.default_rng(0), "Generator", "self.kept,"),
        (np.array([Silent()]), "ndarray", "self.kept,"),
        (iter([1]), "list_iterator", "self.kept,"),
    ],
)
def test_anything_else_is_refused_when_an_episode_begins(task: Any, value: object, kind: str, where: str) -> None:
    """The message names task, type, attribute and the remedy."""
    task.kept = value
    with pytest.raises(TaskError, match=rf"Task 'keeper' keeps a {kind} in {where}.*state\(\) and set_state"):
        task.begin_episode(0, np.random.default_rng(0))


def test_a_task_has_one_variation_unless_it_says_otherwise(task: Any) -> None:
    """Most tasks do not."""
    assert task.variation_count() == 1
