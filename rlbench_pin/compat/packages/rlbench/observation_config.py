"""Contents of observations, with arguments in the order of RLBench."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np

from pyrep.const import RenderMode
from rlbench.noise_model import GaussianNoise, Identity, NoiseModel
from rlbench_pin.environment.observations import CameraConfig as NativeCameraConfig
from rlbench_pin.environment.observations import GaussianNoise as NativeGaussianNoise
from rlbench_pin.environment.observations import Identity as NativeIdentity
from rlbench_pin.environment.observations import NoiseModel as NativeNoiseModel
from rlbench_pin.environment.observations import ObservationConfig as NativeObservationConfig
from rlbench_pin.errors import CameraError, UnknownName
from rlbench_pin.values import Rule

_SHADOWS = {"opengl": False, "opengl_auxiliary": False, "opengl3": True, "opengl3_windowed": True}
"""Name of a render mode -> whether it draws shadows."""


@dataclass(frozen=True)
class _GlobalNoise:
    """Adapter for a noise model that draws from numpy's global generator and ignores the generator of the observer."""

    model: Any

    def apply(self, value: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Return `value` with noise."""
        return np.asarray(self.model.apply(np.array(value)))


def _adapted(model: Any) -> NativeNoiseModel:
    """Return a noise model with the interface that the observer calls; None is no noise."""
    if model is None or isinstance(model, Identity):
        return NativeIdentity()
    native = isinstance(model, NativeIdentity | NativeGaussianNoise | _GlobalNoise)
    return model if native else _GlobalNoise(model)  # type: ignore[no-any-return]


class CameraConfig(NativeCameraConfig):
    """Images of one camera; see `rlbench_pin.CameraConfig`.

    `render_mode` is a member of `pyrep.const.RenderMode`: OPENGL3 draws shadows, OPENGL is faster and draws none. Programs may
    set any attribute.
    """

    rules: ClassVar[Mapping[str, Rule]] = {}
    closed: ClassVar[bool] = False

    def __init__(
        self,
        rgb: bool = True,
        rgb_noise: NoiseModel | None = None,
        depth: bool = True,
        depth_noise: NoiseModel | None = None,
        point_cloud: bool = True,
        mask: bool = True,
        image_size: Sequence[int] = (128, 128),
        render_mode: RenderMode | str = RenderMode.OPENGL3,
        masks_as_one_channel: bool = True,
        depth_in_meters: bool = False,
    ) -> None:
        self.rgb, self.depth, self.point_cloud, self.mask = rgb, depth, point_cloud, mask
        self.rgb_noise: Any = Identity() if rgb_noise is None else rgb_noise
        self.depth_noise: Any = Identity() if depth_noise is None else depth_noise
        self.image_size: Any = image_size
        self.render_mode: Any = render_mode
        self.masks_as_one_channel, self.depth_in_meters = masks_as_one_channel, depth_in_meters

    def __setattr__(self, name: str, value: Any) -> None:
        """Set an attribute; `image_size` is converted to a tuple."""
        if name == "image_size":
            value = tuple(int(side) for side in value)
        super().__setattr__(name, value)

    @property
    def draws_shadows(self) -> bool:
        """Whether objects cast shadows on each other."""
        return _SHADOWS.get(_mode_name(self.render_mode), False)

    def noise_of(self, product: Literal["rgb", "depth"]) -> NativeNoiseModel:
        """Return the noise model of colours or of depth."""
        return _adapted(self.rgb_noise if product == "rgb" else self.depth_noise)

    def check(self, name: str) -> None:
        """Raise CameraError for an invalid image size, and UnknownName for an unknown render mode."""
        size = self.image_size
        if len(size) != 2 or min(size) < 1:
            raise CameraError(f"Camera '{name}' has image_size {size}; width and height must be at least 1 px. Set `image_size`.")
        if _mode_name(self.render_mode) not in _SHADOWS:
            raise UnknownName("render mode", str(self.render_mode), tuple(f"RenderMode.{n.upper()}" for n in _SHADOWS))


def _mode_name(mode: object) -> str:
    """Return the name of a `RenderMode`, or of a string with its name, in lower case."""
    return str(getattr(mode, "name", mode)).lower()


class ObservationConfig(NativeObservationConfig):
    """Five cameras and the low-dimensional data of each observation; see `rlbench_pin.ObservationConfig`.

    A camera that is None gets new default settings. With `record_ignore_collisions`, observations of demonstrations contain the
    collision flag of their segment. Programs may set any attribute.
    """

    rules: ClassVar[Mapping[str, Rule]] = {}
    closed: ClassVar[bool] = False

    def __init__(
        self,
        left_shoulder_camera: NativeCameraConfig | None = None,
        right_shoulder_camera: NativeCameraConfig | None = None,
        overhead_camera: NativeCameraConfig | None = None,
        wrist_camera: NativeCameraConfig | None = None,
        front_camera: NativeCameraConfig | None = None,
        joint_velocities: bool = True,
        joint_velocities_noise: NoiseModel | None = None,
        joint_positions: bool = True,
        joint_positions_noise: NoiseModel | None = None,
        joint_forces: bool = True,
        joint_forces_noise: NoiseModel | None = None,
        gripper_open: bool = True,
        gripper_pose: bool = True,
        gripper_matrix: bool = False,
        gripper_joint_positions: bool = False,
        gripper_touch_forces: bool = False,
        wrist_camera_matrix: bool = False,
        record_gripper_closing: bool = False,
        task_low_dim_state: bool = False,
        record_ignore_collisions: bool = True,
    ) -> None:
        given = (left_shoulder_camera, right_shoulder_camera, overhead_camera, wrist_camera, front_camera)
        cameras: list[Any] = [CameraConfig() if camera is None else camera for camera in given]
        noises: list[Any] = [joint_velocities_noise, joint_positions_noise, joint_forces_noise]
        noises = [Identity() if noise is None else noise for noise in noises]
        super().__init__(
            cameras[0], cameras[1], cameras[2], cameras[3], cameras[4],
            joint_velocities, noises[0], joint_positions, noises[1], joint_forces, noises[2],
            gripper_open, gripper_pose, gripper_matrix, gripper_joint_positions, gripper_touch_forces, wrist_camera_matrix,
            record_gripper_closing, task_low_dim_state, record_ignore_collisions,
        )  # fmt: skip

    def noise_of(self, name: str) -> NativeNoiseModel | None:
        """Return the noise model of a low-dimensional field; None if it has no such setting."""
        noise = getattr(self, f"{name}_noise", None)
        return None if noise is None else _adapted(noise)


__all__ = ["CameraConfig", "GaussianNoise", "Identity", "NoiseModel", "ObservationConfig"]
