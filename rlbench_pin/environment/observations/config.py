"""Which parts of an observation are delivered, and how."""

from __future__ import annotations

from dataclasses import dataclass, field

from rlbench_pin.environment.observations.camera_config import CameraConfig
from rlbench_pin.environment.observations.extra_cameras import ExtraCamera
from rlbench_pin.environment.observations.model_based import ModelObservationConfig
from rlbench_pin.environment.observations.noise import Identity, NoiseModel
from rlbench_pin.errors import CameraError, UnknownName
from rlbench_pin.observation import CAMERAS
from rlbench_pin.sim import Lighting


@dataclass
class ObservationConfig:
    """Five cameras and the low-dimensional data of each observation. Every camera gets a fresh default."""

    left_shoulder_camera: CameraConfig = field(default_factory=CameraConfig)
    right_shoulder_camera: CameraConfig = field(default_factory=CameraConfig)
    overhead_camera: CameraConfig = field(default_factory=CameraConfig)
    wrist_camera: CameraConfig = field(default_factory=CameraConfig)
    front_camera: CameraConfig = field(default_factory=CameraConfig)
    joint_velocities: bool = True
    joint_velocities_noise: NoiseModel = field(default_factory=Identity)
    joint_positions: bool = True
    joint_positions_noise: NoiseModel = field(default_factory=Identity)
    joint_forces: bool = True
    joint_forces_noise: NoiseModel = field(default_factory=Identity)
    gripper_open: bool = True
    gripper_pose: bool = True
    gripper_matrix: bool = False
    gripper_joint_positions: bool = False
    gripper_touch_forces: bool = False
    wrist_camera_matrix: bool = False
    record_gripper_closing: bool = False
    task_low_dim_state: bool = False
    model: ModelObservationConfig = field(default_factory=ModelObservationConfig)
    """Jacobians, dynamics and distances, put into `misc`; all off."""
    lighting: Lighting = field(default_factory=Lighting)
    """The lights of all pictures."""
    extra_cameras: dict[str, ExtraCamera] = field(default_factory=dict)
    """Cameras beside the five; see `add_camera`."""

    def __post_init__(self) -> None:
        for name in CAMERAS:
            if getattr(self, f"{name}_camera") is None:
                setattr(self, f"{name}_camera", CameraConfig())

    def cameras(self) -> dict[str, CameraConfig]:
        """Return the five camera settings by name."""
        return {name: getattr(self, f"{name}_camera") for name in CAMERAS}

    def camera(self, name: str) -> CameraConfig:
        """Return the settings of a camera, one of the five or an extra one.

        Raises:
            UnknownName: There is no such camera; names the nearest.
        """
        known = {**self.cameras(), **{extra: camera.config for extra, camera in self.extra_cameras.items()}}
        if name not in known:
            raise UnknownName("camera", name, tuple(known))
        return known[name]

    def add_camera(self, name: str, camera: ExtraCamera) -> ExtraCamera:
        """Add a camera; its pictures become attributes `<name>_rgb` and so on of observations.

        Raises:
            CameraError: The name is in use, or the camera makes no picture.
        """
        if not name.isidentifier() or name in CAMERAS or name in self.extra_cameras:
            raise CameraError(f"A camera cannot be called '{name}': choose an identifier that no other camera has.")
        camera.check(name)
        self.extra_cameras[name] = camera
        return camera

    def remove_camera(self, name: str) -> None:
        """Remove a camera that was added.

        Raises:
            UnknownName: There is no extra camera of that name; the five are switched off with `set_all(False)`.
        """
        if name not in self.extra_cameras:
            raise UnknownName("extra camera", name, tuple(self.extra_cameras))
        del self.extra_cameras[name]

    def set_all(self, value: bool) -> None:
        """Switch everything but `record_gripper_closing`."""
        self.set_all_high_dim(value)
        self.set_all_low_dim(value)

    def set_all_high_dim(self, value: bool) -> None:
        """Switch all products of all cameras."""
        for camera in self.cameras().values():
            camera.set_all(value)

    def set_all_low_dim(self, value: bool) -> None:
        """Switch all joint, gripper and task data."""
        for name in (
            "joint_velocities",
            "joint_positions",
            "joint_forces",
            "gripper_open",
            "gripper_pose",
            "gripper_matrix",
            "gripper_joint_positions",
            "gripper_touch_forces",
            "wrist_camera_matrix",
            "task_low_dim_state",
        ):
            setattr(self, name, value)

    def check(self) -> None:
        """Raise CameraError or UnknownName when a camera cannot be served."""
        for name, camera in self.cameras().items():
            camera.check(name)
        for name, extra in self.extra_cameras.items():
            extra.check(name)


__all__ = ["CameraConfig", "ExtraCamera", "ObservationConfig"]
