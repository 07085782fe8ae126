"""Standard environments for demonstrations, recordings and checks."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from rlbench_pin.environment.actions.modes import Discrete, JointPosition, MoveArmThenGripper
from rlbench_pin.environment.actions.pose import EndEffectorPoseViaPlanning
from rlbench_pin.environment.environment import Environment
from rlbench_pin.environment.observations.config import CameraConfig, ExtraCamera, ObservationConfig
from rlbench_pin.errors import InvalidCamera
from rlbench_pin.observation import CAMERAS
from rlbench_pin.robot.description import DEFAULT_ROBOT
from rlbench_pin.sim import RendererName, look_at
from rlbench_pin.spatial import above_table
from rlbench_pin.values import as_names


def low_dim_config() -> ObservationConfig:
    """Return a config with all joint, gripper and task data, without images.

    Joint poses are omitted: `RobotModel.joint_poses` computes them from the joint positions.
    """
    config = ObservationConfig(joint_poses=False)
    config.set_all_high_dim(False)
    config.set_all_low_dim(True)
    return config


def image_config(
    image_size: tuple[int, int], cameras: Collection[str] = CAMERAS, *, depth: bool = True, mask: bool = True
) -> ObservationConfig:
    """Return a config with all joint, gripper and task data, and the images of some cameras.

    Point clouds are omitted: they can be computed from depth and the camera matrices in `misc`.
    """
    config = low_dim_config()
    for name in as_names(cameras, "cameras", InvalidCamera):
        camera = config.camera(name)
        camera.rgb, camera.depth, camera.mask, camera.image_size = True, depth, mask, image_size
    return config


def clear_view(image_size: tuple[int, int] = (128, 128)) -> dict[str, ExtraCamera]:
    """Return three cameras with few occlusions; assign them to `extra_cameras` to add them to the five standard cameras.

    At the reset, the standard camera `front` does not show the gripper, and `overhead` is behind the arm. `clear_front` shows
    the whole arm and the whole table top. `clear_overhead` is in front of the arm and looks back and down, so that the arm
    hides little. `clear_robot_side` is behind the arm, on its left, and shows the fronts of appliances.

    Args:
        image_size: Width and height [px].
    """
    ahead = look_at((1.5, 0.0, above_table(1.1)), (0.12, 0.0, above_table(0.38)))
    above = look_at((0.8, 0.0, above_table(1.7)), (0.22, 0.0, above_table(0.1)))
    behind = look_at((-0.72, 0.62, above_table(0.92)), (0.30, 0.06, above_table(0.16)))
    places = {"clear_front": (ahead, 46.0), "clear_overhead": (above, 44.0), "clear_robot_side": (behind, 48.0)}
    return {
        name: ExtraCamera(pose=pose, config=CameraConfig(image_size=image_size), fov=float(np.radians(fov)))
        for name, (pose, fov) in places.items()
    }


def make_environment(
    config: ObservationConfig,
    renderer: RendererName = "cpu",
    max_velocity: float = 1.0,
    max_acceleration: float = 4.0,
    robot: str = DEFAULT_ROBOT,
) -> Environment:
    """Return an environment with the actions of recorded demonstrations: absolute joint positions and the gripper."""
    return Environment(
        joint_position_mode(),
        obs_config=config,
        robot_setup=robot,
        arm_max_velocity=max_velocity,
        arm_max_acceleration=max_acceleration,
        seed=0,
        renderer=renderer,
    )


def joint_position_mode() -> MoveArmThenGripper:
    """Return the action mode of recorded demonstrations: absolute joint positions and the gripper."""
    return MoveArmThenGripper(JointPosition(), Discrete())


def key_frame_mode() -> MoveArmThenGripper:
    """Return the action mode of agents that predict key frames: a tip pose to plan for, then the gripper.

    If planning of a segment fails, it is planned again without collision checks.
    """
    return MoveArmThenGripper(EndEffectorPoseViaPlanning(retry_without_checks=True), Discrete())
