"""Cameras of the user's own, beside the five."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import ClassVar

import numpy as np

from rlbench_pin.environment.observations.camera_config import CameraConfig
from rlbench_pin.errors import InvalidCamera
from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.sim import CameraView, World
from rlbench_pin.spatial import FloatArray, compose, se3_to_pose
from rlbench_pin.values import Rule, Settings, as_number, as_pose, as_text, record_of, ruled

HAND = "hand"
"""Parent of cameras that ride on the hand."""

_LENGTH: Rule = partial(as_number, error=InvalidCamera, above=0.0)


@dataclass(kw_only=True)
class ExtraCamera(Settings):
    """One more camera. Assign to its fields to move or change it; the next observation follows.

    Its products are the attributes `<name>_rgb`, `<name>_depth`, `<name>_mask` and `<name>_point_cloud` of an observation.
    """

    rules: ClassVar[Mapping[str, Rule]] = ruled(
        (_LENGTH, "near far"),
        (partial(as_number, error=InvalidCamera, above=0.0, most=float(np.pi)), "fov"),
        (partial(as_pose, error=InvalidCamera), "pose"),
        (partial(as_text, error=InvalidCamera), "parent"),
        (record_of(CameraConfig), "config"),
    )

    pose: Sequence[float] | FloatArray
    """Pose (7,) in its parent: camera z forward, x left, y up. `look_at` makes one."""
    config: CameraConfig = field(default_factory=CameraConfig)
    """What it delivers."""
    fov: float = float(np.radians(40.0))
    """Field of view of the longer side [rad]."""
    near: float = 0.01
    """Near plane [m]."""
    far: float = 4.5
    """Far plane [m]."""
    parent: str = "world"
    """`world`, `hand`, or a body, link or frame of the scene that it rides on."""

    def check(self, name: str) -> None:
        """Raise CameraError when no picture can be taken."""
        as_pose(self.pose, f"The pose of camera '{name}'", InvalidCamera)
        self.config.check(name)
        CameraView(pose=np.array(self.pose, dtype=float), fov=self.fov, size=self.config.image_size, near=self.near, far=self.far)

    def view(self, world: World, robot: RobotDescription) -> CameraView:
        """Return what it sees at this instant."""
        pose = np.array(self.pose, dtype=float)
        if self.parent == HAND:
            pose = compose(world.robot.link_pose(robot.hand_link), pose)
        elif self.parent != "world":
            pose = compose(se3_to_pose(world.placement(self.parent)), pose)
        return CameraView(pose=pose, fov=self.fov, size=self.config.image_size, near=self.near, far=self.far)
