"""Cameras are moved during an episode, stay where they were put, and go back when asked to."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from rlbench_pin.environment import CameraConfig, Environment, ExtraCamera, JointPositionActionMode, ObservationConfig
from rlbench_pin.environment.observations.observe import camera_view
from rlbench_pin.errors import CameraError, EnvironmentClosed, UnknownName
from rlbench_pin.sim import look_at
from rlbench_pin.spatial import pose_to_matrix, relative

ELSEWHERE = look_at((1.1, 0.6, 1.7), (0.25, 0.0, 0.85))


@pytest.fixture
def env() -> Iterator[Environment]:
    """An environment with small front and wrist cameras."""
    config = ObservationConfig()
    config.set_all_high_dim(False)
    config.front_camera = CameraConfig(image_size=(32, 24))
    config.wrist_camera = CameraConfig(image_size=(32, 24))
    config.wrist_camera_matrix = True
    with Environment(JointPositionActionMode(), obs_config=config, seed=0) as environment:
        yield environment


def test_pictures_and_matrices_follow_and_only_the_user_undoes_it(env):
    """A moved camera stays through resets, states and tasks; `reset_pose` brings the very same images back."""
    task = env.get_task("reach_target")
    _, before = task.reset(seed=1)
    state = task.get_state()
    task.runtime.cameras["front"].set_pose(ELSEWHERE)
    after = task.get_observation()
    np.testing.assert_array_equal(after.misc["front_camera_extrinsics"], pose_to_matrix(ELSEWHERE))
    np.testing.assert_array_equal(task.runtime.cameras["front"].pose, ELSEWHERE)
    np.testing.assert_array_equal(after.misc["front_camera_intrinsics"], before.misc["front_camera_intrinsics"])
    assert (after.front_rgb != before.front_rgb).any() and (after.wrist_rgb == before.wrist_rgb).all()
    for again in (task.set_state(state), task.reset(seed=1)[1], env.get_task("reach_target").reset(seed=1)[1]):
        np.testing.assert_array_equal(again.front_rgb, after.front_rgb)
        np.testing.assert_array_equal(again.front_point_cloud, after.front_point_cloud)
    env.cameras["front"].reset_pose()
    np.testing.assert_array_equal(env.get_task("reach_target").reset(seed=1)[1].front_rgb, before.front_rgb)


def test_a_moved_camera_draws_as_an_extra_one_there(env):
    """The images are those of any camera at that pose."""
    task = env.get_task("reach_target")
    task.reset(seed=1)
    task.runtime.cameras["front"].set_pose(ELSEWHERE)
    config = task.runtime.cameras["front"].config
    task.runtime.cameras.config.add_camera("twin", ExtraCamera(pose=ELSEWHERE, config=config))
    seen = task.get_observation()
    np.testing.assert_array_equal(seen.front_rgb, seen.twin_rgb)
    np.testing.assert_array_equal(seen.front_mask, seen.twin_mask)


def test_cameras_that_ride_go_on_riding(env):
    """The wrist camera, moved, keeps its new place in the gripper; its matrix in misc follows."""
    task = env.get_task("reach_target")
    task.reset(seed=1)
    wrist = task.runtime.cameras["wrist"]
    assert wrist.parent == "hand" and not wrist.moved
    wrist.set_pose(ELSEWHERE)
    np.testing.assert_allclose(wrist.pose, ELSEWHERE, atol=1e-12)
    tip = task.get_observation().gripper_pose
    action = np.zeros(8)
    action[[0, 7]] = 0.1, 0.04
    seen, _, _ = task.step(action)
    assert np.abs(seen.gripper_pose - tip).max() > 1e-3
    np.testing.assert_allclose(relative(wrist.pose, seen.gripper_pose), relative(ELSEWHERE, tip), atol=1e-6)
    np.testing.assert_array_equal(seen.misc["wrist_camera_extrinsics"], seen.misc["wrist_camera_matrix"])
    np.testing.assert_allclose(seen.misc["wrist_camera_matrix"], pose_to_matrix(wrist.pose), atol=1e-12)


def test_before_the_first_task_and_in_scene_data(env):
    """Cameras can be moved after `launch()`, before a task is chosen; the data of the scene say so."""
    env.cameras["front"].set_pose(ELSEWHERE)
    np.testing.assert_array_equal(env.get_scene_data()["front_camera"]["extrinsics"], pose_to_matrix(ELSEWHERE))
    _, seen = env.get_task("reach_target").reset(seed=0)
    np.testing.assert_array_equal(seen.misc["front_camera_extrinsics"], pose_to_matrix(ELSEWHERE))
    assert list(env.cameras) == ["left_shoulder", "right_shoulder", "overhead", "wrist", "front"] and len(env.cameras) == 5


def test_views_without_moves_are_those_of_the_settings(env):
    """The handles change nothing by being there."""
    task = env.get_task("reach_target")
    for name in task.runtime.cameras:
        camera = task.runtime.cameras[name]
        assert camera.view().key == camera_view(name, camera.config, task.world, task.runtime.description).key


@pytest.mark.parametrize("pose", [(0.0, 0.0), "up", (0, 0, 1, 0, 0, 0, 0), (0, 0, np.nan, 0, 0, 0, 1), None])
def test_what_is_no_pose_is_refused(env, pose):
    """A typed error that names the camera; it stays where it was."""
    camera = env.cameras["front"]
    with pytest.raises(CameraError, match="front"):
        camera.set_pose(pose)
    assert not camera.moved


def test_unknown_cameras_and_closed_environments_are_named(env):
    """The nearest name, and the next step."""
    with pytest.raises(UnknownName, match="'front'"):
        env.cameras["frnt"]
    env.shutdown()
    with pytest.raises(EnvironmentClosed, match="launch"):
        _ = env.cameras
