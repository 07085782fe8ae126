"""Planning modes and loops in the shape of the older dialect, and demonstrations that a program plays by itself."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from pyrep.const import ObjectType
from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import EndEffectorPoseViaPlanning, RelativeFrame, calculate_delta_pose
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.backend.scene import Scene
from rlbench.environment import Environment
from rlbench.tasks import OpenDrawer, PickAndLift, ReachTarget, TakeLidOffSaucepan
from tests.compat.scenes import fresh_scene, launched

DOWN = [0.0, 1.0, 0.0, 0.0]


@pytest.fixture(scope="module")
def environment() -> Iterator[Environment]:
    """An environment without pictures."""
    yield from launched()


@pytest.fixture
def scene(environment: Environment) -> Any:
    """The scene of a fresh episode."""
    return fresh_scene(environment)


class DialectPlanning(EndEffectorPoseViaPlanning):
    """A planning mode in the shape of the older dialect: frames by words, shapes switched off while it plans."""

    def action(self, scene: Scene, action: np.ndarray, ignore_collisions: bool = True) -> None:  # type: ignore[override]
        """Plan around everything but what the arm touches."""
        if not self._absolute_mode and self._frame != "end effector":
            action = calculate_delta_pose(scene.robot, action)
        relative_to = None if self._frame == "world" else scene.robot.arm.get_tip()
        self._quick_boundary_check(scene, action)
        if self._robot_shapes is None:
            self._robot_shapes = scene.robot.arm.get_objects_in_tree(object_type=ObjectType.SHAPE)
        touched = [
            shape
            for shape in scene.pyrep.get_objects_in_tree(object_type=ObjectType.SHAPE)
            if shape.is_collidable() and shape not in self._robot_shapes and scene.robot.arm.check_arm_collision(shape)
        ]
        for shape in touched:
            shape.set_collidable(False)
        path = scene.robot.arm.get_path(
            action[:3], quaternion=action[3:], ignore_collisions=not self._collision_checking, relative_to=relative_to
        )
        for shape in touched:
            shape.set_collidable(True)
        done = False
        while not done:
            done = path.step()
            scene.step()


@pytest.mark.parametrize(
    ("arguments", "action"),
    [
        ((True, "world", True), [0.3, 0.1, 1.2, *DOWN]),
        ((False, "world", True), [0.0, 0.05, -0.1, 0.0, 0.0, 0.0, 1.0]),
        ((True, "end effector", True), [0.0, 0.0, 0.05, 0.0, 0.0, 0.0, 1.0]),
        ((), [0.3, 0.1, 1.2, *DOWN]),
    ],
)
def test_a_mode_in_the_older_dialect(scene: Any, arguments: tuple[Any, ...], action: list[float]) -> None:
    """Whatever frame it is given, by word or by default, it goes where the known rules say."""
    tip = scene.robot.arm.get_tip()
    matrix, position = tip.get_matrix(), tip.get_position()
    goals = {
        (False, "world", True): position + action[:3],
        (True, "end effector", True): position + 0.05 * matrix[:3, 2],
    }
    MoveArmThenGripper(DialectPlanning(*arguments), Discrete()).action(scene, np.array([*action, 1.0]))
    np.testing.assert_allclose(tip.get_position(), goals.get(arguments, action[:3]), atol=1e-3)


def test_frames_equal_their_words() -> None:
    """And nothing else."""
    assert RelativeFrame.WORLD == "world" and RelativeFrame.EE != "world" and RelativeFrame.EE == 1
    assert {RelativeFrame.EE: 3}[RelativeFrame(1)] == 3


def play(scene: Scene) -> bool:
    """Follow the waypoints of a task, and operate the hand as they say; return whether the goal was reached."""
    gripper = scene.robot.gripper
    for point in scene.task.get_waypoints():
        point.start_of_path()
        path = point.get_path()
        done = False
        while not done:
            done = path.step()
            scene.step()
        point.end_of_path()
        words = point.get_ext()
        if "gripper(" not in words:
            continue
        opens = "open_gripper(" in words
        if opens:
            gripper.release()
        done = False
        while not done:
            done = gripper.actuate(1.0 if opens else 0.0, velocity=0.04)
            scene.pyrep.step()
            scene.task.step()
        if not opens:
            for graspable in scene.task.get_graspable_objects():
                gripper.grasp(graspable)
    return bool(scene.task.success()[0])


@pytest.mark.parametrize("task", [ReachTarget, TakeLidOffSaucepan, PickAndLift, OpenDrawer])
def test_a_program_plays_a_demonstration_by_itself(environment: Environment, task: type) -> None:
    """Paths, fingers and grasps suffice to reach the goals of tasks."""
    np.random.seed(4)
    loaded = environment.get_task(task)
    loaded.reset()
    assert play(loaded._scene)
