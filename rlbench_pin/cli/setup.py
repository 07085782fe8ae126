"""Environments as the commands use them."""

from __future__ import annotations

from collections.abc import Collection

from rlbench_pin.environment import Discrete, Environment, JointPosition, MoveArmThenGripper, ObservationConfig
from rlbench_pin.observation import CAMERAS
from rlbench_pin.tasks import Task, load_task_file, task_class


def find_task(name: str) -> type[Task]:
    """Return the task of that name, or the one in the file when `name` ends with `.py`."""
    return load_task_file(name) if name.endswith(".py") else task_class(name)


def low_dim_config() -> ObservationConfig:
    """All joint, gripper and task data; no pictures."""
    config = ObservationConfig()
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
    for name in cameras:
        camera = config.cameras()[name]
        camera.rgb, camera.depth, camera.mask, camera.image_size = True, depth, mask, image_size
    return config


def make_environment(config: ObservationConfig) -> Environment:
    """An environment whose actions are the ones that demonstrations record: absolute joint positions and the hand."""
    return Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=config, seed=0)
