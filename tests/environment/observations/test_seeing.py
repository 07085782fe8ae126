"""Extra cameras, noise, lights and their mistakes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from rlbench_pin.environment import (
    CameraConfig,
    Discrete,
    Environment,
    ExtraCamera,
    GaussianNoise,
    JointPosition,
    MoveArmThenGripper,
    ObservationConfig,
    TaskEnvironment,
)
from rlbench_pin.environment.observations.observe import camera_view, point_cloud
from rlbench_pin.errors import CameraError, UnknownName
from rlbench_pin.observation import CAMERAS
from rlbench_pin.sim import look_at

SIDE_VIEW = look_at((0.3, 1.2, 1.4), (0.25, 0.0, 0.85))


def config_of(**front: object) -> ObservationConfig:
    """The front camera alone, small."""
    config = ObservationConfig()
    config.set_all_high_dim(False)
    config.front_camera = CameraConfig(image_size=(32, 24), **front)
    return config


@pytest.fixture(scope="module")
def task_env() -> Iterator[TaskEnvironment]:
    """reach_target with a small front camera."""
    with Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=config_of(), seed=0) as env:
        task = env.get_task("reach_target")
        task.reset(seed=0)
        yield task


def test_extra_cameras_come_move_and_go(task_env):
    """A camera that is added delivers its products and matrices, follows its pose and its parent, and is gone when removed."""
    config = task_env.runtime.observer.config
    camera = config.add_camera("side", ExtraCamera(pose=SIDE_VIEW, config=CameraConfig(image_size=(40, 30))))
    first = task_env.get_observation()
    assert first.side_rgb.shape == (30, 40, 3) and first.side_point_cloud.shape == (30, 40, 3)
    np.testing.assert_allclose(first.misc["side_camera_extrinsics"][:3, 3], SIDE_VIEW[:3])
    camera.pose = look_at((0.3, -1.2, 1.4), (0.25, 0.0, 0.85))
    assert (task_env.get_observation().side_rgb != first.side_rgb).any()
    camera.parent, camera.pose = "hand", np.array([0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    hand = task_env.world.robot.link_pose(task_env.runtime.description.hand_link)
    seen = task_env.get_observation().misc["side_camera_extrinsics"][:3, 3]
    assert np.linalg.norm(seen - hand[:3]) == pytest.approx(0.1, abs=1e-6)
    config.remove_camera("side")
    assert not hasattr(task_env.get_observation(), "side_rgb")


def test_unknown_and_impossible_cameras_are_refused():
    """Typed errors with the next step."""
    config = ObservationConfig()
    with pytest.raises(UnknownName, match="left_shoulder"):
        config.camera("left_sholder")
    with pytest.raises(UnknownName):
        config.remove_camera("front")
    with pytest.raises(CameraError):
        config.add_camera("front", ExtraCamera(pose=SIDE_VIEW))
    for change in ({"near": 2.0, "far": 1.0}, {"fov": 0.0}, {"pose": (0.0, 0.0)}, {"pose": (0.0,) * 7}):
        with pytest.raises(CameraError):
            config.add_camera("side", ExtraCamera(**{"pose": SIDE_VIEW, **change}))
    config.extra_cameras["side"] = ExtraCamera(pose=SIDE_VIEW, near=3.0, far=1.0)
    with pytest.raises(CameraError):
        Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=config)


def test_noise_is_seeded_and_depth_noise_reaches_the_point_cloud():
    """The same seed gives the same noise; the point cloud is that of the noisy depth; rgb stays bytes."""
    config = config_of(rgb_noise=GaussianNoise(0.05, (0.0, 1.0)), depth_noise=GaussianNoise(0.01), depth_in_meters=True)
    with Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=config, seed=0) as env:
        task = env.get_task("reach_target")
        first, second = task.reset(seed=3)[1], task.reset(seed=3)[1]
        view = camera_view("front", config.front_camera, task.world, task.runtime.description)
        config.front_camera.rgb_noise = config.front_camera.depth_noise = CameraConfig().rgb_noise
        clean = task.get_observation()
    np.testing.assert_array_equal(first.front_rgb, second.front_rgb)
    np.testing.assert_array_equal(first.front_depth, second.front_depth)
    assert first.front_rgb.dtype == np.uint8 and (first.front_rgb != clean.front_rgb).any()
    assert 0.005 < np.std(first.front_depth - clean.front_depth) < 0.02
    np.testing.assert_allclose(first.front_point_cloud, point_cloud(first.front_depth, view), atol=1e-6)


def test_only_what_is_enabled_is_delivered(task_env):
    """Switched-off products are None, switched-off cameras have no misc."""
    config = task_env.runtime.observer.config
    config.front_camera.set_all(False)
    config.front_camera.mask = True
    observation = task_env.get_observation()
    config.front_camera.set_all(True)
    assert observation.front_rgb is None and observation.front_depth is None and observation.front_mask is not None
    assert all(f"{name}_camera_far" not in observation.misc for name in CAMERAS if name != "front")


def test_no_camera_sees_a_flat_white_background(task_env):
    """Every pixel of the five cameras shows something with an id, and hardly any is pure white."""
    for name in CAMERAS:
        view = camera_view(name, CameraConfig(), task_env.world, task_env.runtime.description)
        pictures = task_env.world.render(view, shadows=True)
        assert (pictures.mask > 0).mean() > 0.99
        assert (pictures.rgb.min(axis=2) > 253).mean() < 0.02


def test_arm_table_and_fingers_are_in_the_pictures(task_env):
    """The front camera sees arm and table top; the wrist camera sees the fingers and what is below."""
    world, robot = task_env.world, task_env.runtime.description
    seen = {}
    for name in ("front", "wrist"):
        mask = world.render(camera_view(name, CameraConfig(), world, robot)).mask
        seen[name] = {world.masks[i] for i in np.unique(mask)}
    assert "table" in seen["front"] and any("panda_link4" in name for name in seen["front"])
    assert "table" in seen["wrist"] and sum("finger" in name for name in seen["wrist"]) == 2


@pytest.mark.simulation
def test_ids_stay_over_twenty_resets():
    """The table of names is the same after every reset, and every id that is seen is in it."""
    config = ObservationConfig()
    config.set_all_high_dim(False)
    for camera in config.cameras().values():
        camera.mask, camera.image_size = True, (32, 32)
    with Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=config, seed=0) as env:
        task = env.get_task("stack_blocks")
        task.set_variation(-1)
        table = None
        for seed in range(20):
            observation = task.reset(seed=seed)[1]
            table = table or dict(task.world.masks)
            assert dict(task.world.masks) == table
            for name in CAMERAS:
                mask = getattr(observation, f"{name}_mask")
                assert mask.dtype == np.int32 and set(np.unique(mask)) <= {0, *table}
    assert all(number > 60 for number, name in table.items() if name.split("/")[0] in task.world.bodies)
