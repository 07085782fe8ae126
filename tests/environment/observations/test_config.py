"""Which parts of an observation are delivered."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.environment import (
    CameraConfig,
    Discrete,
    Environment,
    GaussianNoise,
    JointVelocity,
    MoveArmThenGripper,
    ObservationConfig,
)
from rlbench_pin.errors import CameraError, UnknownName
from rlbench_pin.observation import CAMERAS, PRODUCTS, Observation


def observe(config: ObservationConfig, task: str = "pick_and_lift") -> Observation:
    with Environment(MoveArmThenGripper(JointVelocity(), Discrete()), obs_config=config, seed=0) as env:
        return env.get_task(task).reset(seed=0)[1]


def test_every_config_gets_fresh_cameras() -> None:
    """Changing one config leaves another alone."""
    one, two = ObservationConfig(), ObservationConfig()
    one.front_camera.image_size = (64, 64)
    assert two.front_camera.image_size == (128, 128)


def test_all_products_have_the_documented_shapes_and_types() -> None:
    """Images are height x width with the stated types, and every pixel of a mask is an integer id."""
    config = ObservationConfig()
    for camera in config.cameras().values():
        camera.image_size = (64, 48)
    obs = observe(config)
    for camera in CAMERAS:
        rgb, depth, mask, cloud = (getattr(obs, f"{camera}_{product}") for product in PRODUCTS)
        assert (rgb.shape, rgb.dtype) == ((48, 64, 3), np.uint8)
        assert (depth.shape, depth.dtype) == ((48, 64), np.float32)
        assert mask.shape == (48, 64)
        assert np.issubdtype(mask.dtype, np.integer)
        assert cloud.shape == (48, 64, 3)
        assert 0.0 <= depth.min() <= depth.max() <= 1.0
        assert rgb.std() > 5, f"{camera} shows nothing"
        k, t = obs.misc[f"{camera}_camera_intrinsics"], obs.misc[f"{camera}_camera_extrinsics"]
        assert k[0, 0] < 0 > k[1, 1]
        near, far = obs.misc[f"{camera}_camera_near"], obs.misc[f"{camera}_camera_far"]
        z = near + float(depth[20, 30]) * (far - near)
        point = t[:3, :3] @ (np.linalg.inv(k) @ [30.0, 20.0, 1.0] * z) + t[:3, 3]
        assert np.abs(point - cloud[20, 30]).max() < 1e-4


def test_what_is_switched_off_is_none() -> None:
    """A config without anything gives empty fields and no camera entries."""
    config = ObservationConfig()
    config.set_all(False)
    obs = observe(config)
    assert obs.get_low_dim_data().shape == (0,)
    assert all(getattr(obs, f"{camera}_{product}") is None for camera in CAMERAS for product in PRODUCTS)
    assert "front_camera_near" not in obs.misc


def test_a_point_cloud_alone_is_delivered() -> None:
    """A camera with only its point cloud on gives one."""
    config = ObservationConfig()
    config.set_all(False)
    config.front_camera.point_cloud = True
    obs = observe(config)
    assert obs.front_point_cloud.shape == (128, 128, 3)
    assert obs.front_rgb is None
    assert obs.front_depth is None


def test_noise_is_seeded_and_changes_no_argument() -> None:
    """The same seed gives the same noise."""
    config = ObservationConfig()
    config.set_all_high_dim(False)
    config.joint_positions_noise = GaussianNoise(0.01)
    a, b = observe(config), observe(config)
    assert np.array_equal(a.joint_positions, b.joint_positions)
    quiet = ObservationConfig()
    quiet.set_all_high_dim(False)
    assert 0 < np.abs(a.joint_positions - observe(quiet).joint_positions).max() < 0.1


def test_empty_pictures_are_refused() -> None:
    """Size 0 is refused where it enters, also later."""
    with pytest.raises(CameraError, match=r"CameraConfig.image_size has to be a whole number >= 1 and <= 8192. Got 0"):
        CameraConfig(image_size=(0, 128))
    config = ObservationConfig()
    with pytest.raises(CameraError, match="image_size"):
        config.front_camera.image_size = (128, 0)
    assert config.front_camera.image_size == (128, 128)


def test_an_unknown_render_mode_is_refused_at_once() -> None:
    """When the settings are made, and when they are changed."""
    with pytest.raises(UnknownName, match="No CameraConfig.render_mode is called 'opengl9'. Did you mean 'opengl'"):
        CameraConfig(render_mode="opengl9")  # type: ignore[arg-type]
    config = CameraConfig(render_mode="opengl")
    with pytest.raises(UnknownName, match="opengl9"):
        config.render_mode = "opengl9"  # type: ignore[assignment]
    assert config.render_mode == "opengl"
