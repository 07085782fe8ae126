"""Where the five cameras stand and what they see."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from rlbench_pin.environment.observations.camera_config import CameraConfig
from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.sim import CameraView, World, look_at
from rlbench_pin.spatial import above_table, compose

# name -> (position [m], point looked at [m], field of view [rad], near [m], far [m]); they stand with the table
_FIXED = {
    "left_shoulder": ((-0.175, 0.2, above_table(1.228)), (0.37, 0.10, above_table(0.048)), np.radians(40.0), 0.01, 3.2),
    "right_shoulder": ((-0.175, -0.2, above_table(1.228)), (0.37, -0.10, above_table(0.048)), np.radians(40.0), 0.01, 3.2),
    "overhead": ((-0.175, 0.0, above_table(1.678)), (0.22, 0.0, above_table(0.0)), np.radians(40.0), 0.01, 3.3),
    "front": ((1.35, 0.0, above_table(0.828)), (0.15, 0.0, above_table(0.268)), np.radians(40.0), 0.01, 4.5),
}
_WRIST = (np.radians(60.0), 0.01, 3.5)


_POSES = {name: look_at(eye, target) for name, (eye, target, *_rest) in _FIXED.items()}


def camera_view(name: str, config: CameraConfig, world: World, robot: RobotDescription) -> CameraView:
    """Return the view of camera `name` at this instant."""
    if name == "wrist":
        fov, near, far = _WRIST
        pose = compose(world.robot.link_pose(robot.hand_link), robot.camera_pose)
        return CameraView(pose=pose, fov=fov, size=config.image_size, near=near, far=far)
    return _fixed_view(name, tuple(config.image_size))


@lru_cache(maxsize=32)
def _fixed_view(name: str, size: tuple[int, int]) -> CameraView:
    """View of a camera that stands still; one object, so that its rays are computed once."""
    _eye, _target, fov, near, far = _FIXED[name]
    return CameraView(pose=_POSES[name], fov=fov, size=size, near=near, far=far)
