"""Tasks that make their objects in every episode, play their waypoints in rounds, or bring no scene of their own."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from rlbench import Environment, ObservationConfig
from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import EndEffectorPoseViaPlanning
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.tasks import OpenDrawer
from tests.compat import paper_tasks

pytestmark = pytest.mark.simulation

EMPTY = """
import numpy as np
from pyrep.const import PrimitiveShape
from pyrep.objects.dummy import Dummy
from pyrep.objects.proximity_sensor import ProximitySensor
from pyrep.objects.shape import Shape
from rlbench.backend.conditions import ConditionSet, DetectedCondition, NothingGrasped
from rlbench.backend.spawn_boundary import SpawnBoundary
from rlbench.backend.task import Task


class EmptyTheBox(Task):

    def load(self):
        base = super().load()
        Shape('plate').set_color([0.2, 0.2, 0.9])
        return base

    def init_task(self):
        self.boundary = SpawnBoundary([Shape('spawn')])
        self.target = ProximitySensor('success')
        self.register_waypoint_ability_start(0, self._to_object)
        self.register_waypoints_should_repeat(self._repeat)
        self.aims = 0
        self.objects = []

    def init_episode(self, index):
        self.objects = []
        for _ in range(2):
            cube = Shape.create(PrimitiveShape.CUBOID, [0.04, 0.04, 0.04], mass=0.1, color=[1.0, 0.0, 0.0])
            cube.set_parent(self.get_base())
            self.objects.append(cube)
        self.boundary.clear()
        for cube in self.objects:
            cube.set_position([0.0, 0.0, 0.021], relative_to=Shape('spawn'), reset_dynamics=False)
            self.boundary.sample(cube, min_distance=0.12, min_rotation=(0, 0, -0.1), max_rotation=(0, 0, 0.1))
        self.left = list(self.objects)
        self.register_graspable_objects(self.objects)
        seen = ConditionSet([DetectedCondition(cube, self.target) for cube in self.objects], simultaneously_met=True)
        self.register_success_conditions([seen, NothingGrasped(self.robot.gripper)])
        return ['bring both cubes onto the plate']

    def variation_count(self):
        return 1

    def cleanup(self):
        [cube.remove() for cube in self.objects if cube.still_exists()]
        self.objects = []

    def _to_object(self, waypoint):
        self.aims += 1
        x, y, z = self.left[0].get_position()
        waypoint.get_waypoint_object().set_position([x, y, z + 0.1])
        Dummy('waypoint1').set_position([x, y, z])
        Dummy('waypoint3').set_position([0.05 * len(self.left) - 0.07, 0.0, 0.06], relative_to=Shape('plate'))

    def _repeat(self):
        self.left.pop(0)
        return len(self.left) > 0

    def is_static_workspace(self):
        return True
"""

SCENE = """
format = 2

[placement]
pose = [0.3, 0.0, 0.0]

[[body]]
name = "plate"
asset = "objects/target_square/target_square.urdf"
pose = [0.0, 0.2, 0.0]
fixed = true
collides = false

[[region]]
name = "spawn"
pose = [0.0, -0.1, 0.0]
size = [0.3, 0.3, 0.0]

[[sensor]]
name = "over_plate"
parent = "plate"
pose = [0.0, 0.0, 0.1]
shape = "box"
size = [0.2, 0.2, 0.2]

[[waypoint]]
name = "waypoint0"
pose = [0.0, -0.1, 0.15]
rpy = [3.1415927, 0.0, 0.0]

[[waypoint]]
name = "waypoint1"
pose = [0.0, -0.1, 0.05]
rpy = [3.1415927, 0.0, 0.0]
gripper = "close"

[[waypoint]]
name = "waypoint2"
parent = "waypoint1"
pose = [0.0, 0.0, -0.12]
ignore_collisions = true

[[waypoint]]
name = "waypoint3"
parent = "plate"
pose = [0.0, 0.0, 0.06]
rpy = [3.1415927, 0.0, 0.0]
gripper = "open"
"""


@pytest.fixture(scope="module")
def environment() -> Iterator[Environment]:
    """An environment without images."""
    config = ObservationConfig()
    config.set_all_high_dim(False)
    config.task_low_dim_state = True
    env = Environment(MoveArmThenGripper(EndEffectorPoseViaPlanning(), Discrete()), "", config, True)
    yield env
    env.shutdown()


def test_objects_made_anew_in_every_episode(environment: Environment, tmp_path: Path) -> None:
    """Each episode has its own two cubes; both are brought onto the plate in two rounds, again and again."""
    module = paper_tasks.write_task(tmp_path, "empty_the_box", EMPTY, SCENE)
    np.random.seed(3)
    task = environment.get_task(module.EmptyTheBox)
    user, world = task._task, environment._scene.runtime.world
    sizes = set()
    for _ in range(2):
        demo = task.get_demos(1, live_demos=True)[0]
        assert user.success() == (True, True) and user.left == [] and len(user.objects) == 2
        assert len(world.bodies) == 3 and sorted(user.native.get_graspable_objects()) == sorted(world.spawned)
        sizes.add(len(demo[0].task_low_dim_state))
    assert user.aims >= 4 and len(sizes) == 1
    assert world.body("plate").color[:3] == pytest.approx((0.2, 0.2, 0.9))
    state = environment._scene.runtime.save()
    places = [cube.get_position() for cube in user.objects]
    task.reset()
    assert not np.allclose(places, [cube.get_position() for cube in user.objects])
    environment._scene.runtime.restore(state)
    assert np.allclose(places, [cube.get_position() for cube in user.objects]) and user.left == []


POLE = """

class LidAndPole(LiftTheLid):

    def init_task(self):
        super().init_task()
        self.pole = Shape.create(PrimitiveShape.CUBOID, [0.02, 0.02, 0.1], static=True, respondable=False)
        self.pole.set_parent(self.get_base())
        self.pole.set_position([0.2, 0.0, 0.05], relative_to=self.get_base())
        Shape.create(PrimitiveShape.CUBOID, [0.02, 0.02, 0.02], static=True, position=[0.7, 0.5, 0.9])
"""


def test_what_init_task_makes_is_part_of_the_state(environment: Environment, tmp_path: Path) -> None:
    """A shape that hangs in the task comes last, in every episode; zeros once it is removed. One that hangs nowhere is not."""
    code = "from pyrep.const import PrimitiveShape\n" + paper_tasks.LID + POLE
    module = paper_tasks.write_task(tmp_path, "lid_and_pole", code, paper_tasks.LID_SCENE)
    task = environment.get_task(module.LidAndPole)
    for _ in range(2):
        state = task.reset()[1].task_low_dim_state
        assert state.shape == (21,)
        np.testing.assert_allclose(state[14:], task._task.pole.get_pose(), atol=1e-6)
    task._task.pole.remove()
    state = task.get_observation().task_low_dim_state
    assert state.shape == (21,) and not state[14:].any()


def test_a_task_called_like_one_of_the_library_has_its_scene(environment: Environment, tmp_path: Path) -> None:
    """Without a scene of its own beside it; the only sensor of a scene answers to `success`."""
    code = paper_tasks.LID.replace("LiftTheLid", "TakeLidOffSaucepan")
    module = paper_tasks.write_task(tmp_path, "my_version", code, "")
    (tmp_path / "my_version.toml").unlink()
    task = environment.get_task(module.TakeLidOffSaucepan)
    assert task.get_name() == "take_lid_off_saucepan" and type(task._task.native).user_class is module.TakeLidOffSaucepan
    assert len(task.get_demos(1, live_demos=True)[0]) > 20


def test_classes_travel() -> None:
    """Classes of tasks go to other processes by their names."""
    assert pickle.loads(pickle.dumps(OpenDrawer)) is OpenDrawer
