"""Settings of observations: noise, cameras, low-dimensional fields with their bounds, and model-based quantities."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import ClassVar, Literal, Protocol, runtime_checkable

import numpy as np

from rlbench_pin.errors import CameraError, InvalidCamera, InvalidValue, UnknownName, shown
from rlbench_pin.observation import CAMERAS
from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.sim import CameraView, Lighting, World
from rlbench_pin.spatial import FloatArray, compose, pose_to_matrix, se3_to_pose
from rlbench_pin.tasks import Task
from rlbench_pin.values import (
    FLAG,
    NOT_NEGATIVE,
    Rule,
    Settings,
    as_choice,
    as_image_size,
    as_interval,
    as_number,
    as_pose,
    as_text,
    check_settings,
    counted,
    record_of,
    ruled,
)


@runtime_checkable
class NoiseModel(Protocol):
    """Adds noise to a measured array, without changing its argument."""

    def apply(self, value: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Return `value` with noise from `rng`."""
        ...


class Identity:
    """No noise."""

    def apply(self, value: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Return `value` itself."""
        return value


def as_noise(value: object, what: str) -> NoiseModel:
    """Return `value`, or raise InvalidValue if it is not a noise model."""
    if isinstance(value, type) or not isinstance(value, NoiseModel):
        hint = "For example `GaussianNoise(0.01)`, or `Identity()` for no noise."
        raise InvalidValue(what, value, "has to be a noise model, an object with `apply(value, rng)`", hint)
    return value


def _as_clip(value: object, what: str) -> tuple[float, float] | None:
    return None if value is None else as_interval(value, what, finite=False)


class GaussianNoise(Settings):
    """Additive normal noise.

    Args:
        variance: Standard deviation, in the unit of the value; the name is that of RLBench.
        min_max_clip: Lower and upper bound to which the noisy value is clipped.

    Raises:
        InvalidValue: The deviation is NaN, infinite or negative, or the lower bound is above the upper one.
    """

    rules: ClassVar[Mapping[str, Rule]] = {"variance": NOT_NEGATIVE, "min_max_clip": _as_clip}
    variance: float
    min_max_clip: tuple[float, float] | None

    def __init__(self, variance: float, min_max_clip: tuple[float, float] | None = None) -> None:
        self.variance, self.min_max_clip = variance, min_max_clip

    def apply(self, value: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Return a noisy copy of `value` with the same dtype."""
        value = np.asarray(value)
        noisy = value + rng.normal(0.0, self.variance, value.shape)
        return (noisy if self.min_max_clip is None else np.clip(noisy, *self.min_max_clip)).astype(value.dtype)


RenderMode = Literal["opengl", "opengl3"]
"""Render modes: `opengl3` draws shadows, `opengl` does not."""

IMAGE_SIZE_RULE: Rule = partial(as_image_size, error=InvalidCamera)


@dataclass(kw_only=True)
class CameraConfig(Settings):
    """Products of one camera at each observation.

    Raises:
        InvalidValue: An invalid value is assigned to a setting.
        UnknownName: An unknown `render_mode` is assigned.
        UnknownSetting: There is no such setting (also an AttributeError).
    """

    rules: ClassVar[Mapping[str, Rule]] = ruled(
        (FLAG, "rgb depth point_cloud mask masks_as_one_channel depth_in_meters antialiasing"),
        (as_noise, "rgb_noise depth_noise"),
        (IMAGE_SIZE_RULE, "image_size"),
        (partial(as_choice, choices=("opengl", "opengl3")), "render_mode"),
    )

    rgb: bool = True
    """Colours, uint8 (h, w, 3)."""
    rgb_noise: NoiseModel = field(default_factory=Identity)
    """Noise of colours in 0..1."""
    depth: bool = True
    """Depth along the optical axis, float32 (h, w): 0..1 from the near to the far plane, or [m] with `depth_in_meters`."""
    depth_noise: NoiseModel = field(default_factory=Identity)
    """Noise of depth [m]; it also affects the point cloud."""
    point_cloud: bool = True
    """World coordinates of every pixel, float32 (h, w, 3) [m]."""
    mask: bool = True
    """Id of the object at each pixel, int32 (h, w); `misc["mask_names"]` has the names."""
    image_size: tuple[int, int] = (128, 128)
    """Width and height [px]; one integer sets both."""
    render_mode: RenderMode = "opengl3"
    """`opengl3` draws shadows, `opengl` is faster without."""
    antialiasing: bool = True
    """Smooth the edges between surfaces in colours; depth and masks do not change."""
    masks_as_one_channel: bool = True
    """Masks as one integer per pixel; otherwise (h, w, 3) float32 in 0..1 with the id spread over the channels."""
    depth_in_meters: bool = False
    """Depth in [m]; otherwise 0..1, linear between the near and the far plane."""

    def set_all(self, value: bool) -> None:
        """Enable or disable rgb, depth, point cloud and mask together."""
        self.rgb = self.depth = self.point_cloud = self.mask = value

    @property
    def is_used(self) -> bool:
        """Return whether any product is enabled."""
        return self.rgb or self.depth or self.point_cloud or self.mask

    @property
    def draws_shadows(self) -> bool:
        """Return whether objects cast shadows on each other."""
        return self.render_mode == "opengl3"

    def noise_of(self, product: Literal["rgb", "depth"]) -> NoiseModel:
        """Return the noise of colours or of depth."""
        return self.rgb_noise if product == "rgb" else self.depth_noise

    def check(self, name: str) -> None:
        """Raise CameraError if the settings are invalid."""
        width, height = self.image_size
        if width < 1 or height < 1:
            raise CameraError(
                f"Camera '{name}' has image_size {self.image_size}; width and height must be at least 1 px. "
                "Set `image_size` to two such numbers."
            )


HAND = "hand"
"""Parent of cameras that are mounted on the gripper."""

_LENGTH: Rule = partial(as_number, error=InvalidCamera, above=0.0)


@dataclass(kw_only=True)
class ExtraCamera(Settings):
    """An additional camera. Changes of its fields apply from the next observation.

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
    """Products of the camera."""
    fov: float = float(np.radians(40.0))
    """Field of view of the longer side [rad]."""
    near: float = 0.01
    """Near plane [m]."""
    far: float = 4.5
    """Far plane [m]."""
    parent: str = "world"
    """`world`, `hand`, or a body, link or frame of the scene that it is mounted on."""

    def check(self, name: str) -> None:
        """Raise CameraError if the settings are invalid."""
        as_pose(self.pose, f"The pose of camera '{name}'", InvalidCamera)
        self.config.check(name)
        CameraView(pose=np.array(self.pose, dtype=float), fov=self.fov, size=self.config.image_size, near=self.near, far=self.far)

    def view(self, world: World, robot: RobotDescription) -> CameraView:
        """Return the view of the camera at this instant."""
        pose = np.array(self.pose, dtype=float)
        if self.parent == HAND:
            pose = compose(world.robot.link_pose(robot.hand_link), pose)
        elif self.parent != "world":
            pose = compose(se3_to_pose(world.placement(self.parent)), pose)
        return CameraView(pose=pose, fov=self.fov, size=self.config.image_size, near=self.near, far=self.far)


_MODEL_RULES = ruled(
    (FLAG, "tip_jacobian tip_jacobian_dot mass_matrix gravity coriolis manipulability"),
    (counted(0), "world_distances self_distances"),
)


@dataclass(frozen=True, kw_only=True)
class ModelObservationConfig:
    """Model-based quantities in observations; none by default.

    They are written to `Observation.misc` under the names of the settings:

    | key | value |
    |---|---|
    | `tip_jacobian` | (6, n), `[linear, angular]` of the tip along world axes per joint velocity |
    | `tip_jacobian_dot` | its time derivative, (6, n) |
    | `mass_matrix` | joint-space inertia, (n, n), [kg m^2] |
    | `gravity` | torques that compensate gravity, (n,), [N m] |
    | `coriolis` | C(q, v) v, (n,), [N m] |
    | `manipulability` | sqrt(det(J J^T)) |
    | `world_distances`, `self_distances` | the nearest pairs as `Distance` records: names, distance [m], points, normal |
    """

    tip_jacobian: bool = False
    tip_jacobian_dot: bool = False
    mass_matrix: bool = False
    gravity: bool = False
    coriolis: bool = False
    manipulability: bool = False
    world_distances: int = 0
    """Number of nearest pairs between arm and world."""
    self_distances: int = 0
    """Number of nearest pairs between links of the arm."""

    def __post_init__(self) -> None:
        """Raise InvalidValue for a switch that is not a bool, or a number of pairs that is not an integer >= 0."""
        check_settings(self, _MODEL_RULES)

    @property
    def is_used(self) -> bool:
        """Return whether any quantity is enabled."""
        return any(vars(self).values())


JOINT_SPEED = 100.0
"""Maximum joint velocity in the simulator [rad/s]."""
TOUCH_FORCE = 1e5
"""Bound of contact forces [N]."""
TASK_STATE = 1e3
"""Bound of object states: positions [m], joint values [m] or [rad]."""
TIP_POSE = np.array([3.0] * 3 + [1.0] * 4)
"""Bound of the tip pose, larger than the reach of the arm: positions [m], then the quaternion."""
OPEN = 0.9
"""Fraction of its range above which the first finger is open."""


@dataclass(frozen=True)
class Instant:
    """Source of low-dimensional data."""

    world: World
    """The simulated world."""
    model: RobotModel
    """Analytic model of its robot."""
    task: Task
    """The running task."""


@dataclass(frozen=True)
class LowDimField:
    """A low-dimensional field of `Observation`; the setting of the same name in `ObservationConfig` enables it."""

    read: Callable[[Instant], FloatArray | float]
    """Value at an instant, as a copy."""
    bound: Callable[[Instant], FloatArray]
    """Largest magnitude of each value, shape (n,)."""
    lowest: float | None = None
    """Lowest value; None is minus the bound."""

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
"""All low-dimensional fields, in the order in which their noise is drawn."""


def _as_camera(value: object, what: str) -> CameraConfig:
    if value is None:
        return CameraConfig()
    if not isinstance(value, CameraConfig):
        raise InvalidCamera(what, value, "has to be a CameraConfig, or None for the default settings")
    return value


_SWITCHES = (
    *LOW_DIM_FIELDS, "wrist_camera_matrix", "record_gripper_closing", "record_ignore_collisions", "joint_poses",
)  # fmt: skip
"""All settings that are switches."""


@dataclass
class ObservationConfig(Settings):
    """Settings of the five cameras and of the low-dimensional data in each observation.

    Raises:
        InvalidValue: An invalid value is assigned to a setting.
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
    """Write `wrist_camera_matrix` to `misc`: wrist camera to world (4, 4)."""
    record_gripper_closing: bool = False
    """Keep a frame of demonstrations for each tick of finger motion, not only the last."""
    task_low_dim_state: bool = False
    record_ignore_collisions: bool = True
    """Write `ignore_collisions` to the frames of demonstrations."""
    joint_poses: bool = True
    """Write the world poses (7,) of the arm joints to `misc` as a list; `set_all` does not change this setting."""
    model: ModelObservationConfig = field(default_factory=ModelObservationConfig)
    """Jacobians, dynamics and distances in `misc`; all disabled by default."""
    lighting: Lighting = field(default_factory=Lighting)
    """The lights of all images."""
    extra_cameras: dict[str, ExtraCamera] = field(default_factory=dict)
    """Additional cameras by name; see `add_camera`."""

    def cameras(self) -> dict[str, CameraConfig]:
        """Return the five camera settings by name."""
        return {name: getattr(self, f"{name}_camera") for name in CAMERAS}

    def all_cameras(self) -> dict[str, CameraConfig]:
        """Return the settings of the five cameras and of the additional ones by name."""
        return {**self.cameras(), **{name: extra.config for name, extra in self.extra_cameras.items()}}

    def camera(self, name: str) -> CameraConfig:
        """Return the settings of a camera, one of the five or an additional one.

        Raises:
            UnknownName: There is no such camera; the message proposes the most similar one.
        """
        known = self.all_cameras()
        return known[as_choice(name, "camera", tuple(known))]

    def add_camera(self, name: str, camera: ExtraCamera) -> ExtraCamera:
        """Add a camera; its images become attributes `<name>_rgb` and so on of observations.

        Raises:
            CameraError: The name is invalid or in use, or a setting is invalid.
        """
        if not isinstance(name, str) or not name.isidentifier() or name in CAMERAS or name in self.extra_cameras:
            raise CameraError(f"A camera cannot have the name {shown(name)}. Choose an identifier that no other camera has.")
        if not isinstance(camera, ExtraCamera):
            raise InvalidCamera(f"Camera '{name}'", camera, "has to be an ExtraCamera")
        camera.check(name)
        self.extra_cameras[name] = camera
        return camera

    def remove_camera(self, name: str) -> None:
        """Remove an additional camera.

        Raises:
            UnknownName: There is no additional camera of that name; `set_all(False)` disables the five cameras.
        """
        if not isinstance(name, str) or name not in self.extra_cameras:
            raise UnknownName("extra camera", name, tuple(self.extra_cameras))
        del self.extra_cameras[name]

    def set_all(self, value: bool) -> None:
        """Enable or disable all products except `record_gripper_closing` and `joint_poses`."""
        self.set_all_high_dim(value)
        self.set_all_low_dim(value)

    def set_all_high_dim(self, value: bool) -> None:
        """Enable or disable all products of all cameras."""
        for camera in self.cameras().values():
            camera.set_all(value)

    def set_all_low_dim(self, value: bool) -> None:
        """Enable or disable all joint, gripper and task data."""
        for name in (*LOW_DIM_FIELDS, "wrist_camera_matrix"):
            setattr(self, name, value)

    def noise_of(self, name: str) -> NoiseModel | None:
        """Return the noise of a low-dimensional field; None if it has no noise setting."""
        noise: NoiseModel | None = getattr(self, f"{as_text(name, 'name')}_noise", None)
        return noise

    def check(self) -> None:
        """Raise CameraError or UnknownName if the settings of a camera are invalid."""
        for name, camera in self.cameras().items():
            camera.check(name)
        for name, extra in self.extra_cameras.items():
            extra.check(name)
