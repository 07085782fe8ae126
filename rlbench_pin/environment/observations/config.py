"""Which parts of an observation are delivered, and how; what low-dimensional data are read from, and in which bounds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from rlbench_pin.environment.observations.camera_config import CameraConfig
from rlbench_pin.environment.observations.extra_cameras import ExtraCamera
from rlbench_pin.environment.observations.model_based import ModelObservationConfig
from rlbench_pin.environment.observations.noise import Identity, NoiseModel, as_noise
from rlbench_pin.errors import CameraError, InvalidCamera, UnknownName, shown
from rlbench_pin.observation import CAMERAS
from rlbench_pin.robot import RobotModel
from rlbench_pin.sim import Lighting, World
from rlbench_pin.spatial import FloatArray, pose_to_matrix
from rlbench_pin.tasks import Task
from rlbench_pin.values import FLAG, Rule, Settings, as_choice, as_text, record_of, ruled

JOINT_SPEED = 100.0
"""The simulator lets no joint turn faster [rad/s]."""
TOUCH_FORCE = 1e5
"""Bound of contact forces [N]."""
TASK_STATE = 1e3
"""Bound of the numbers that describe objects: positions [m], joint values [m] or [rad]."""
TIP_POSE = np.array([3.0] * 3 + [1.0] * 4)
"""Bound of the tip pose, which the arm cannot leave: positions [m], then the quaternion."""
OPEN = 0.9
"""Fraction of its range above which the first finger counts as open."""


@dataclass(frozen=True)
class Instant:
    """What low-dimensional data are read from."""

    world: World
    """The simulated world."""
    model: RobotModel
    """Analytic model of its robot."""
    task: Task
    """The running task."""


@dataclass(frozen=True)
class LowDimField:
    """A low-dimensional field of `Observation`; `ObservationConfig` switches it by its name."""

    read: Callable[[Instant], FloatArray | float]
    """Value at an instant, not shared with the simulation."""
    bound: Callable[[Instant], FloatArray]
    """Largest magnitude of each number, shape (n,)."""
    lowest: float | None = None
    """Smallest value; None is minus the bound."""

    def bounds(self, instant: Instant) -> tuple[FloatArray, FloatArray]:
        """Return lowest and highest values, each of shape (n,)."""
        high = self.bound(instant)
        return (-high if self.lowest is None else np.full(len(high), self.lowest)), high


def _per_joint(value: float) -> Callable[[Instant], FloatArray]:
    return lambda now: np.full(now.model.size, value)


LOW_DIM_FIELDS: Mapping[str, LowDimField] = {
    "joint_velocities": LowDimField(lambda now: now.world.robot.joint_velocities, _per_joint(JOINT_SPEED)),
    "joint_positions": LowDimField(lambda now: now.world.robot.joint_positions, _per_joint(2.0 * np.pi)),
    "joint_forces": LowDimField(lambda now: now.world.robot.joint_torques, lambda now: np.array(now.model.limits.effort)),
    "gripper_open": LowDimField(
        lambda now: float(now.world.robot.fingers[0] / now.model.description.gripper_open > OPEN), lambda now: np.ones(1), 0.0
    ),
    "gripper_pose": LowDimField(lambda now: now.world.robot.tip_pose(), lambda now: TIP_POSE),
    "gripper_matrix": LowDimField(
        lambda now: pose_to_matrix(now.world.robot.tip_pose()), lambda now: np.append(TIP_POSE[:3], 1.0)
    ),
    "gripper_joint_positions": LowDimField(
        lambda now: now.world.robot.fingers,
        lambda now: np.full(len(now.model.description.gripper_joints), 2.0 * now.model.description.gripper_open),
    ),
    "gripper_touch_forces": LowDimField(
        lambda now: now.world.robot.touch_forces(),
        lambda now: np.full(3 * len(now.model.description.finger_links), TOUCH_FORCE),
    ),
    "task_low_dim_state": LowDimField(
        lambda now: np.array(now.task.get_low_dim_state(), dtype=float),
        lambda now: np.full(len(now.task.get_low_dim_state()), TASK_STATE),
    ),
}
"""Every low-dimensional field, in the order in which their noise is drawn."""


def _as_camera(value: object, what: str) -> CameraConfig:
    if value is None:
        return CameraConfig()
    if not isinstance(value, CameraConfig):
        raise InvalidCamera(what, value, "has to be a CameraConfig, or None for the default settings")
    return value


_SWITCHES = (
    *LOW_DIM_FIELDS, "wrist_camera_matrix", "record_gripper_closing", "record_ignore_collisions", "joint_poses",
)  # fmt: skip
"""Every setting that is on or off."""


@dataclass
class ObservationConfig(Settings):
    """Five cameras and the low-dimensional data of each observation. Every camera gets a fresh default.

    Raises:
        InvalidValue: A setting is given a value that makes no sense, at any time.
        UnknownSetting: There is no such setting (also an AttributeError).
    """

    rules: ClassVar[Mapping[str, Rule]] = ruled(
        (_as_camera, " ".join(f"{name}_camera" for name in CAMERAS)),
        (FLAG, " ".join(_SWITCHES)),
        (as_noise, "joint_velocities_noise joint_positions_noise joint_forces_noise"),
        (record_of(ModelObservationConfig), "model"),
        (record_of(Lighting), "lighting"),
        (record_of(dict), "extra_cameras"),
    )

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
    """Put `wrist_camera_matrix` into `misc`: wrist camera to world (4, 4)."""
    record_gripper_closing: bool = False
    """Demonstrations keep a frame for every tick of finger motion, not only the last."""
    task_low_dim_state: bool = False
    record_ignore_collisions: bool = True
    """Put `ignore_collisions` on the frames of demonstrations."""
    joint_poses: bool = True
    """Poses (7,) of the arm's joints in the world, put into `misc` as a list; `set_all` leaves it alone."""
    model: ModelObservationConfig = field(default_factory=ModelObservationConfig)
    """Jacobians, dynamics and distances, put into `misc`; all off."""
    lighting: Lighting = field(default_factory=Lighting)
    """The lights of all pictures."""
    extra_cameras: dict[str, ExtraCamera] = field(default_factory=dict)
    """Cameras beside the five; see `add_camera`."""

    def cameras(self) -> dict[str, CameraConfig]:
        """Return the five camera settings by name."""
        return {name: getattr(self, f"{name}_camera") for name in CAMERAS}

    def all_cameras(self) -> dict[str, CameraConfig]:
        """Return the settings of the five cameras and of the extra ones by name."""
        return {**self.cameras(), **{name: extra.config for name, extra in self.extra_cameras.items()}}

    def camera(self, name: str) -> CameraConfig:
        """Return the settings of a camera, one of the five or an extra one.

        Raises:
            UnknownName: There is no such camera; names the nearest.
        """
        known = self.all_cameras()
        return known[as_choice(name, "camera", tuple(known))]

    def add_camera(self, name: str, camera: ExtraCamera) -> ExtraCamera:
        """Add a camera; its pictures become attributes `<name>_rgb` and so on of observations.

        Raises:
            CameraError: The name is in use, or the camera makes no picture.
        """
        if not isinstance(name, str) or not name.isidentifier() or name in CAMERAS or name in self.extra_cameras:
            raise CameraError(f"A camera cannot be called {shown(name)}: choose an identifier that no other camera has.")
        if not isinstance(camera, ExtraCamera):
            raise InvalidCamera(f"Camera '{name}'", camera, "has to be an ExtraCamera")
        camera.check(name)
        self.extra_cameras[name] = camera
        return camera

    def remove_camera(self, name: str) -> None:
        """Remove a camera that was added.

        Raises:
            UnknownName: There is no extra camera of that name; the five are switched off with `set_all(False)`.
        """
        if not isinstance(name, str) or name not in self.extra_cameras:
            raise UnknownName("extra camera", name, tuple(self.extra_cameras))
        del self.extra_cameras[name]

    def set_all(self, value: bool) -> None:
        """Switch everything but `record_gripper_closing` and `joint_poses`."""
        self.set_all_high_dim(value)
        self.set_all_low_dim(value)

    def set_all_high_dim(self, value: bool) -> None:
        """Switch all products of all cameras."""
        for camera in self.cameras().values():
            camera.set_all(value)

    def set_all_low_dim(self, value: bool) -> None:
        """Switch all joint, gripper and task data."""
        for name in (*LOW_DIM_FIELDS, "wrist_camera_matrix"):
            setattr(self, name, value)

    def noise_of(self, name: str) -> NoiseModel | None:
        """Return the noise of a low-dimensional field, None where it has no setting."""
        noise: NoiseModel | None = getattr(self, f"{as_text(name, 'name')}_noise", None)
        return noise

    def check(self) -> None:
        """Raise CameraError or UnknownName when a camera cannot be served."""
        for name, camera in self.cameras().items():
            camera.check(name)
        for name, extra in self.extra_cameras.items():
            extra.check(name)


__all__ = ["LOW_DIM_FIELDS", "CameraConfig", "ExtraCamera", "Instant", "LowDimField", "ObservationConfig"]
