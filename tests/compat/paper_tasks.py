"""Task files as users write them, with scenes of ours beside them."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import Any

LID = """
from typing import List
from pyrep.objects.shape import Shape
from pyrep.objects.proximity_sensor import ProximitySensor
from rlbench.backend.conditions import DetectedCondition, GraspedCondition
from rlbench.backend.task import Task


class LiftTheLid(Task):

    def init_task(self) -> None:
        self.lid = Shape('lid')
        success_detector = ProximitySensor('success')
        self.register_graspable_objects([self.lid])
        self.register_success_conditions([
            GraspedCondition(self.robot.gripper, self.lid),
            DetectedCondition(self.lid, success_detector)])

    def init_episode(self, index: int) -> List[str]:
        return ['take lid off the saucepan', 'remove the lid from the pan']

    def variation_count(self) -> int:
        return 1

    def reward(self) -> float:
        return -abs(self.lid.get_position()[2] - ProximitySensor('success').get_position()[2])
"""

LID_SCENE = """
format = 2

[placement]
footprint = [0.3, 0.3]

[[body]]
name = "saucepan"
asset = "objects/saucepan/saucepan.urdf"
fixed = true

[[body]]
name = "lid"
asset = "objects/saucepan_lid/saucepan_lid.urdf"
parent = "saucepan"
pose = [0.0, 0.0, 0.1215]

[[sensor]]
name = "success"
parent = "saucepan"
pose = [0.0, 0.0, 0.25]
shape = "cylinder"
size = [0.12, 0.06]

[[waypoint]]
name = "waypoint0"
parent = "waypoint1"
pose = [0.0, 0.0, -0.1]
symmetry = 4

[[waypoint]]
name = "waypoint1"
parent = "lid"
rpy = [3.1415927, 0.0, 0.0]
gripper = "close"
symmetry = 4

[[waypoint]]
name = "waypoint2"
parent = "waypoint1"
pose = [0.0, 0.0, -0.15]
ignore_collisions = true
symmetry = 4
"""

CUBES = """
import numpy as np
from pyrep.objects.dummy import Dummy
from pyrep.objects.proximity_sensor import ProximitySensor
from pyrep.objects.shape import Shape
from rlbench.backend.conditions import ConditionSet, DetectedCondition, NothingGrasped
from rlbench.backend.spawn_boundary import SpawnBoundary
from rlbench.backend.task import Task
from rlbench.const import colors


class CubeToPlate(Task):

    def init_task(self):
        self.cube, self.others = Shape('cube0'), [Shape('cube1'), Shape('cube2')]
        self.plate = ProximitySensor('success')
        self.spawns = SpawnBoundary([Shape('boundary')])
        self.register_graspable_objects([self.cube] + self.others)
        on_plate = ConditionSet([DetectedCondition(self.cube, self.plate), NothingGrasped(self.robot.gripper)], True, False)
        self.register_success_conditions([on_plate])
        self.register_waypoint_ability_start(0, self._note)
        self.notes = []

    def init_episode(self, index):
        self.index, self.notes[:] = index, []
        name, rgb = colors[index]
        self.cube.set_color(rgb)
        choice = np.random.choice([i for i in range(len(colors)) if i != index], size=2, replace=False)
        for i, other in zip(choice, self.others):
            other.set_color(colors[i][1])
        self.spawns.clear()
        for item in [self.cube] + self.others:
            self.spawns.sample(item, min_distance=0.08)
        self.drawn = np.random.uniform(size=3)
        return ['put the %s cube on the plate' % name, 'the %s block belongs onto the plate' % name]

    def _note(self, waypoint):
        self.notes.append((waypoint.name, float(np.random.rand())))

    def variation_count(self):
        return len(colors)

    def base_rotation_bounds(self):
        return [0.0, 0.0, -0.1], [0.0, 0.0, 0.1]

    def decorate_observation(self, observation):
        observation.misc['goal_color'] = self.cube.get_color()
        return observation

    def get_low_dim_state(self):
        return np.concatenate([self.cube.get_pose(), self.drawn])
"""

CUBES_SCENE = """
format = 2

[placement]
pose = [0.3, 0.0, 0.0]
footprint = [0.4, 0.5]

[[body]]
name = "plate"
asset = "objects/target_square/target_square.urdf"
pose = [0.0, 0.15, 0.0]
fixed = true
collides = false

[[body]]
name = "cube0"
asset = "objects/cube/cube.urdf"
pose = [0.0, -0.1, 0.025]

[[body]]
name = "cube1"
asset = "objects/cube/cube.urdf"
pose = [0.1, -0.1, 0.025]

[[body]]
name = "cube2"
asset = "objects/cube/cube.urdf"
pose = [-0.1, -0.1, 0.025]

[[region]]
name = "boundary"
pose = [0.0, -0.1, 0.0]
size = [0.36, 0.3, 0.0]

[[sensor]]
name = "success"
parent = "plate"
pose = [0.0, 0.0, 0.03]
shape = "box"
size = [0.1, 0.1, 0.06]

[[waypoint]]
name = "waypoint0"
parent = "waypoint1"
pose = [0.0, 0.0, -0.1]
symmetry = 4

[[waypoint]]
name = "waypoint1"
parent = "cube0"
rpy = [3.1415927, 0.0, 0.0]
gripper = "close"
symmetry = 4

[[waypoint]]
name = "waypoint2"
parent = "waypoint1"
pose = [0.0, 0.0, -0.1]
path = "straight"
ignore_collisions = true
symmetry = 4

[[waypoint]]
name = "waypoint3"
parent = "plate"
pose = [0.0, 0.0, 0.035]
rpy = [3.1415927, 0.0, 0.0]
gripper = "open"
symmetry = 4
"""

DRAWER = '''
from pyrep.objects.joint import Joint
from pyrep.objects.proximity_sensor import ProximitySensor
from pyrep.objects.dummy import Dummy
from pyrep.objects.shape import Shape
from rlbench.backend.conditions import Condition, FollowCondition, JointCondition, OrConditions
from rlbench.backend.task import Task


class Moved(Condition):
    """A condition of one's own that counts how often it was asked."""

    def __init__(self, dummy):
        self.dummy, self.asked, self.start = dummy, 0, None

    def condition_met(self):
        self.asked += 1
        here = self.dummy.get_position()
        if self.start is None:
            self.start = here
        return abs(here - self.start).max() > 0.1, False

    def reset(self):
        self.asked, self.start = 0, None


class PullADrawer(Task):

    def init_task(self):
        self.steps = 0
        self.joints = [Joint('chest/drawer_' + name) for name in self.options()]

    def options(self):
        return ['bottom', 'middle', 'top']

    def init_episode(self, index):
        option = self.options()[index]
        self.steps = 0
        Dummy('waypoint1').set_pose(Dummy('handle_' + option).get_pose())
        self.moved = Moved(Dummy('handle_' + option))
        never = FollowCondition(Shape('chest'), [[0, 0, 5], [0, 0, 6]])
        self.register_success_conditions([
            OrConditions([never, JointCondition(self.joints[index], 0.15)]), self.moved])
        self.register_fail_conditions([FollowCondition(Shape('chest'), [[9, 9, 9]])])
        return ['open the %s drawer' % option]

    def variation_count(self):
        return 3

    def step(self):
        self.steps += 1

    def cleanup(self):
        self.cleaned = True

    def boundary_root(self):
        return Shape('chest')
'''


def write_task(folder: Path, module: str, code: str, scene: str) -> Any:
    """Write a task file and its scene into a folder and return the module, imported by its name."""
    (folder / f"{module}.py").write_text(code)
    (folder / f"{module}.toml").write_text(scene)
    sys.path.insert(0, str(folder))
    try:
        sys.modules.pop(module, None)
        importlib.invalidate_caches()
        return importlib.import_module(module)
    finally:
        sys.path.remove(str(folder))
