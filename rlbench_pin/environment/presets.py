"""Environments as demonstrations, recordings and checks use them."""

from __future__ import annotations

from collections.abc import Collection

from rlbench_pin.environment.actions.action_mode import MoveArmThenGripper
from rlbench_pin.environment.actions.gripper import Discrete
from rlbench_pin.environment.actions.joint import JointPosition
from rlbench_pin.environment.environment import Environment
from rlbench_pin.environment.observations.config import ObservationConfig
from rlbench_pin.errors import InvalidCamera
from rlbench_pin.observation import CAMERAS
from rlbench_pin.sim import RendererName
from rlbench_pin.values import as_names


def low_dim_config() -> ObservationConfig:
    """All joint, gripper and task data; no pictures.

    Poses of joints are left out: `RobotModel.joint_poses` has them from the joint positions.
    """
    config = ObservationConfig(joint_poses=False)
    config.set_all_high_dim(False)
    config.set_all_low_dim(True)
    return config


def picture_config(
    image_size: tuple[int, int], cameras: Collection[str] = CAMERAS, *, depth: bool = True, mask: bool = True
) -> ObservationConfig:
    """All joint, gripper and task data, and pictures of some cameras.

    Point clouds are left out: they follow from depth and the camera matrices in `misc`.
    """
    config = low_dim_config()
    for name in as_names(cameras, "cameras", InvalidCamera):
        camera = config.camera(name)
        camera.rgb, camera.depth, camera.mask, camera.image_size = True, depth, mask, image_size
    return config


def make_environment(
    config: ObservationConfig, renderer: RendererName = "cpu", max_velocity: float = 1.0, max_acceleration: float = 4.0
) -> Environment:
    """An environment whose actions are the ones that demonstrations record: absolute joint positions and the hand."""
    return Environment(
        MoveArmThenGripper(JointPosition(), Discrete()),
        obs_config=config,
        arm_max_velocity=max_velocity,
        arm_max_acceleration=max_acceleration,
        seed=0,
        renderer=renderer,
    )
