"""Cameras and sensors of a runtime, and the observer that reads them into an `Observation`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rlbench_pin.datasets.formats.rlbench import decode_mask
from rlbench_pin.environment.observations.config import (
    HAND,
    LOW_DIM_FIELDS,
    CameraConfig,
    GaussianNoise,
    Identity,
    Instant,
    ModelObservationConfig,
    ObservationConfig,
)
from rlbench_pin.errors import CameraError, InvalidCamera, TaskError, shown
from rlbench_pin.observation import CAMERAS, IN_METRES, LOW_DIM, Observation
from rlbench_pin.robot.collision import Distance
from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.robot.distances import DistanceModel
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.sim import CameraView, ImageNoise, Images, Lighting, Request, World, look_at
from rlbench_pin.spatial import FloatArray, above_table, compose, relative, se3_to_pose
from rlbench_pin.tasks import Task
from rlbench_pin.values import as_vector

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
    """Return the view of a stationary camera; it is cached, so that its rays are computed once."""
    _eye, _target, fov, near, far = _FIXED[name]
    return CameraView(pose=_POSES[name], fov=fov, size=size, near=near, far=far)


_UNIT = 1e-3
"""Maximum deviation of the norm of a quaternion from 1."""
_DUST = 1e-12
"""Deviation of the norm above which a quaternion is normalised; other poses are stored unchanged."""


@dataclass(frozen=True)
class Camera:
    """One camera of a runtime.

    Domain randomization of camera poses is relative to the pose that is set here.
    """

    name: str
    """Name of the camera, such as `front`."""
    cameras: Cameras
    """All cameras of the runtime."""

    @property
    def config(self) -> CameraConfig:
        """Products of the camera."""
        return self.cameras.config.camera(self.name)

    @property
    def parent(self) -> str:
        """Parent of the camera: `world`, `hand`, or a body, link or frame of the scene."""
        return self.cameras.parent(self.name)

    @property
    def pose(self) -> FloatArray:
        """Pose (7,) in the world at this instant: z forward, x left, y up."""
        return np.array(self.view().pose, dtype=float)

    @property
    def moved(self) -> bool:
        """Whether `set_pose` has moved the camera."""
        return self.name in self.cameras.places

    def view(self) -> CameraView:
        """Return the view of the camera at this instant, for `World.render`."""
        return self.cameras.view(self.name)

    def set_pose(self, pose: Sequence[float] | FloatArray) -> None:
        """Move the camera; the new pose applies from the next observation. Its parent does not change.

        The pose stays after resets, `set_state` and a change of the task, until `reset_pose`.

        Args:
            pose: Pose (7,) in the world: z forward, x left, y up. `look_at` computes one.

        Raises:
            CameraError: The value is not a pose.
        """
        self.cameras.move(self.name, _checked(self.name, pose))

    def reset_pose(self) -> None:
        """Restore the pose in the settings."""
        self.cameras.places.pop(self.name, None)


class Cameras:
    """The five cameras and the additional ones of a runtime, by name.

    Args:
        world: The observed world.
        robot: The arm with the wrist camera.
        config: Their settings; read at each call.
        places: Poses (7,) of the moved cameras in their parents, by name; shared by all tasks of an `Environment`.
    """

    def __init__(self, world: World, robot: RobotDescription, config: ObservationConfig, places: dict[str, FloatArray]) -> None:
        self.config, self.places = config, places
        self._world, self._robot = world, robot
        self._views: dict[str, CameraView] = {}

    def __iter__(self) -> Iterator[str]:
        return iter((*CAMERAS, *self.config.extra_cameras))

    def __len__(self) -> int:
        return len(CAMERAS) + len(self.config.extra_cameras)

    def __getitem__(self, name: str) -> Camera:
        self.config.camera(name)  # raises UnknownName
        return Camera(name, self)

    def parent(self, name: str) -> str:
        """Return the parent of a camera: `world`, `hand`, or a body, link or frame of the scene."""
        if name in self.config.extra_cameras:
            return self.config.extra_cameras[name].parent
        return HAND if name == "wrist" else "world"

    def carrier_pose(self, name: str) -> FloatArray:
        """Return the world pose (7,) of the parent of a camera."""
        parent = self.parent(name)
        if parent == "world":
            return np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
        if parent == HAND:
            return np.array(self._world.robot.link_pose(self._robot.hand_link), dtype=float)
        return se3_to_pose(self._world.placement(parent))

    def move(self, name: str, pose: FloatArray) -> None:
        """Move a camera to a pose (7,) in the world; its parent does not change."""
        self.places[name] = pose.copy() if self.parent(name) == "world" else relative(pose, self.carrier_pose(name))

    def view(self, name: str) -> CameraView:
        """Return the view of a camera at this instant."""
        extra = self.config.extra_cameras.get(name)
        if extra is None:
            view = camera_view(name, self.config.camera(name), self._world, self._robot)
        else:
            view = extra.view(self._world, self._robot)
        local = self.places.get(name)
        if local is None:
            return view
        pose = local.copy() if self.parent(name) == "world" else compose(self.carrier_pose(name), local)
        return self._same_or(name, replace(view, pose=pose))

    def _same_or(self, name: str, view: CameraView) -> CameraView:
        """Return the last view of a moved camera if it is still valid, so that its rays are computed once."""
        last = self._views.get(name)
        if last is None or last.key != view.key:
            self._views[name] = view
        return self._views[name]


def _checked(name: str, pose: Sequence[float] | FloatArray) -> FloatArray:
    values = as_vector(pose, 7, f"The pose of camera '{name}'", InvalidCamera).copy()
    norm = float(np.linalg.norm(values[3:]))
    if abs(norm - 1.0) > _UNIT:
        raise CameraError(
            f"The quaternion of camera '{name}' has norm {norm:.4f}. Divide it by its norm; the order is x, y, z, w."
        )
    if abs(norm - 1.0) > _DUST:
        values[3:] /= norm
    return values


def spread_mask(mask: np.ndarray) -> np.ndarray:
    """Encode ids in three channels, lowest byte first, as float32 in 0..1."""
    channels = np.stack([mask & 0xFF, (mask >> 8) & 0xFF, (mask >> 16) & 0xFF], axis=-1)
    return channels.astype(np.float32) / 255.0


def rgb_handles_to_mask(rgb: ArrayLike) -> np.ndarray:
    """Return the ids of a mask in three channels, the lowest byte first: r + 256 g + 65536 b.

    Args:
        rgb: The mask (..., 3): integers in 0..255, as in a PNG file, or floats in 0..1, as with
            `masks_as_one_channel=False`. It is not changed.

    Returns:
        Ids (...), int32.

    Raises:
        CameraError: The mask has another shape or other values.
    """
    try:
        channels = np.asarray(rgb)
    except Exception as error:  # whatever objects raise that are no array
        raise CameraError(f"A mask over three channels has to be an array of numbers, not {shown(rgb)}.") from error
    if channels.ndim == 0 or channels.shape[-1] != 3 or channels.dtype.kind not in "uif":
        raise CameraError(f"A mask over three channels has to have shape (..., 3), not {channels.shape} of {channels.dtype}.")
    highest = 1 if channels.dtype.kind == "f" else 255
    if not np.all((channels >= 0) & (channels <= highest)):
        raise CameraError(f"The channels of a mask of {channels.dtype} lie in 0..{highest}; these do not.")
    return decode_mask(channels if highest == 255 else np.rint(channels * 255.0))


def boxed_settings(cameras: Sequence[str], image_size: tuple[int, int]) -> ObservationConfig:
    """Return settings with all low-dimensional data and the colours of some cameras only.

    Args:
        cameras: Names of the cameras.
        image_size: Width and height [px].

    Raises:
        UnknownName: There is no such camera.
    """
    config = ObservationConfig(joint_poses=False)
    config.set_all(False)
    for name in LOW_DIM:
        setattr(config, name, True)
    for name in cameras:
        camera = config.camera(name)
        camera.rgb, camera.image_size = True, image_size
    return config


def boxed(name: str, value: object, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return the values of an observation field as float32, shape (n,), within their bounds.

    Values beyond a bound, which occur only in an unstable simulation, are clipped. Fewer values than bounds, as in a
    variation of a task with fewer objects, are padded with zeros.

    Args:
        name: Name of the field.
        value: One or several numbers.
        low: Lowest values, shape (n,).
        high: Highest values, shape (n,).

    Raises:
        TaskError: There are more values than bounds.
    """
    array = np.atleast_1d(np.asarray(value, dtype=np.float64))
    if len(array) > len(low):
        raise TaskError(f"'{name}' has grown to {len(array)} numbers; its space holds {len(low)}. A task state has one length.")
    if len(array) < len(low):
        array = np.concatenate([array, np.zeros(len(low) - len(array))])
    return np.clip(array, low, high).astype(np.float32)


def fitted(name: str, value: object, box: Any) -> np.ndarray:
    """Return an observation field as an element of a gymnasium box: images as they are, other fields as `boxed` returns them."""
    return np.asarray(value) if box.dtype == np.uint8 else boxed(name, value, box.low, box.high)


class ModelObserver:
    """Computes the quantities of `ModelObservationConfig` for one world; keeps its distance model between observations.

    Args:
        world: World with the joint states and the poses of all bodies.
        model: Model of the arm.
    """

    def __init__(self, world: World, model: RobotModel) -> None:
        self._world, self._model = world, model
        self._distances: DistanceModel | None = None

    def observe(self, config: ModelObservationConfig) -> dict[str, Any]:
        """Return the enabled quantities by name."""
        q, v = self._world.robot.joint_positions, self._world.robot.joint_velocities
        model = self._model
        ways = {
            "tip_jacobian": lambda: model.jacobian(q).copy(),
            "tip_jacobian_dot": lambda: model.jacobian_dot(q, v),
            "mass_matrix": lambda: model.mass_matrix(q),
            "gravity": lambda: model.gravity(q),
            "coriolis": lambda: model.coriolis(q, v),
            "manipulability": lambda: model.manipulability(q),
        }
        found: dict[str, Any] = {name: way() for name, way in ways.items() if getattr(config, name)}
        if config.world_distances or config.self_distances:
            found.update(self._nearest(config))
        return found

    def _nearest(self, config: ModelObservationConfig) -> dict[str, tuple[Distance, ...]]:
        if self._distances is None:
            self._distances = DistanceModel(self._model)
        snapshot = self._world.snapshot()
        self._distances.update(snapshot)
        bodies = {body.name for body in snapshot.bodies} - set(snapshot.attached)
        pairs = self._distances.nearest(snapshot.arm, count=10_000)
        world = [pair for pair in pairs if pair.a in bodies or pair.b.partition("/")[0] in bodies]
        own = [pair for pair in pairs if pair not in world]
        return {
            **({"world_distances": tuple(world[: config.world_distances])} if config.world_distances else {}),
            **({"self_distances": tuple(own[: config.self_distances])} if config.self_distances else {}),
        }


@dataclass
class Appearance:
    """Deviations of images from the settings, by domain randomization."""

    lighting: Lighting | None = None
    """Lights instead of those in the settings."""
    offsets: dict[str, FloatArray] = field(default_factory=dict)
    """Pose (7,) of each moved camera in its original frame, by name of the camera."""
    fields_of_view: dict[str, float] = field(default_factory=dict)
    """Factor of the field of view of each camera, by name."""
    images: ImageNoise = ImageNoise()
    """Faults of the images."""
    joint_sigma: float = 0.0
    """Standard deviation of measured joint positions [rad]."""
    _views: dict[str, CameraView] = field(default_factory=dict, repr=False)

    def moved(self, name: str, view: CameraView) -> CameraView:
        """Return the view of a camera with its offset and field of view."""
        if name not in self.offsets and name not in self.fields_of_view:
            return view
        pose = compose(view.pose, self.offsets[name]) if name in self.offsets else view.pose
        moved = replace(view, pose=pose, fov=view.fov * self.fields_of_view.get(name, 1.0))
        last = self._views.get(name)
        if last is None or last.key != moved.key:  # otherwise its rays are not computed again
            self._views[name] = moved
        return self._views[name]


class Observer:
    """Returns observations of one world with the contents that an `ObservationConfig` selects.

    Args:
        world: The world to observe.
        model: Analytic model of its robot.
        config: Contents of observations; read at each call, so changes apply at once.
        places: Poses of moved cameras; None means that none has moved.

    Attributes:
        config: The settings.
        appearance: Deviations of images from the settings.
    """

    def __init__(
        self, world: World, model: RobotModel, config: ObservationConfig, places: dict[str, FloatArray] | None = None
    ) -> None:
        self._world, self._arm, self.config = world, model, config
        self.cameras = Cameras(world, model.description, config, {} if places is None else places)
        self._model = ModelObserver(world, model)
        self.appearance = Appearance()

    def use_model(self, model: RobotModel) -> None:
        """Use another model of the arm."""
        self._arm, self._model = model, ModelObserver(self._world, model)

    def observe(self, task: Task, variation: int, rng: np.random.Generator, instructions: Sequence[str] = ()) -> Observation:
        """Return an observation of the present state; its arrays are copies."""
        observation = Observation(misc={"variation_index": variation, "descriptions": list(instructions)})
        instant = Instant(self._world, self._arm, task)
        for name, part in LOW_DIM_FIELDS.items():
            if getattr(self.config, name):
                value, noise = part.read(instant), self.config.noise_of(name)
                setattr(observation, name, value if noise is None else noise.apply(np.asarray(value), rng))
        if self.appearance.joint_sigma and observation.joint_positions is not None:
            noise = GaussianNoise(self.appearance.joint_sigma)
            observation.joint_positions = noise.apply(np.asarray(observation.joint_positions), rng)
        if self.config.model.is_used:
            observation.misc.update(self._model.observe(self.config.model))
        if self.config.joint_poses:
            observation.misc["joint_poses"] = self._arm.joint_poses(self._world.robot.joint_positions)
        views = self._observe_cameras(observation, rng)
        if self.config.wrist_camera_matrix:
            observation.misc["wrist_camera_matrix"] = (views.get("wrist") or self._view("wrist")).extrinsics()
        return task.decorate_observation(observation)

    def _view(self, name: str) -> CameraView:
        """Return the present view of a camera, including `set_pose` and randomization."""
        return self.appearance.moved(name, self.cameras.view(name))

    def _observe_cameras(self, observation: Observation, rng: np.random.Generator) -> dict[str, CameraView]:
        """Add the images of all cameras in one rendering, and return their views."""
        renderer = self._world.renderer
        renderer.lighting = self.appearance.lighting or self.config.lighting
        cameras = {name: config for name, config in self.config.all_cameras().items() if config.is_used}
        if any(config.mask for config in cameras.values()):
            observation.misc["mask_names"] = dict(self._world.masks)
        views = {name: self._view(name) for name in cameras}
        requests = [
            Request(
                views[name],
                config.rgb,
                config.depth or config.point_cloud,
                config.mask,
                config.draws_shadows,
                config.antialiasing,
            )
            for name, config in cameras.items()
        ]
        for (name, config), images in zip(cameras.items(), renderer.render_all(requests), strict=True):
            _add_images(observation, name, config, views[name], images, self.appearance.images, rng)
        return views


def _add_images(
    observation: Observation,
    name: str,
    config: CameraConfig,
    view: CameraView,
    images: Images,
    faults: ImageNoise,
    rng: np.random.Generator,
) -> None:
    """Add the products of one camera."""
    if images.rgb is not None:
        setattr(observation, f"{name}_rgb", _noisy_rgb(faults.apply(images.rgb, name), config, rng))
    if images.depth is not None:
        metres = config.noise_of("depth").apply(faults.apply_to_depth(images.depth, rng), rng)
        if config.point_cloud:
            setattr(observation, f"{name}_point_cloud", point_cloud(metres, view))
        if config.depth:
            setattr(observation, f"{name}_depth", metres if config.depth_in_meters else normalised_depth(metres, view))
            if config.depth_in_meters:
                observation.misc[f"{name}_{IN_METRES}"] = True
    if images.mask is not None:
        setattr(observation, f"{name}_mask", images.mask if config.masks_as_one_channel else spread_mask(images.mask))
    observation.misc.update(camera_misc(name, view))


def _noisy_rgb(rgb: np.ndarray, config: CameraConfig, rng: np.random.Generator) -> np.ndarray:
    noise = config.noise_of("rgb")
    if isinstance(noise, Identity):
        return rgb
    noisy = noise.apply(rgb.astype(np.float32) / 255.0, rng)
    return np.rint(np.clip(noisy, 0.0, 1.0) * 255.0).astype(np.uint8)


def camera_misc(name: str, view: CameraView) -> dict[str, Any]:
    """Return the four `misc` entries that describe a camera."""
    return {
        f"{name}_camera_extrinsics": view.extrinsics(),
        f"{name}_camera_intrinsics": view.intrinsics(),
        f"{name}_camera_near": view.near,
        f"{name}_camera_far": view.far,
    }


def normalised_depth(metres: np.ndarray, view: CameraView) -> np.ndarray:
    """Map depth [m] linearly to 0 at the near and 1 at the far plane."""
    return ((metres - view.near) / (view.far - view.near)).astype(np.float32)


def point_cloud(depth: np.ndarray, view: CameraView) -> np.ndarray:
    """Return the world coordinates [m] of each pixel: extrinsics * inverse(intrinsics) * (u, v, 1) * depth.

    Args:
        depth: Metric depth along the optical axis, shape (h, w), [m].
        view: View of the camera.

    Returns:
        float32 array of shape (h, w, 3).
    """
    height, width = depth.shape
    points = np.empty((height * width, 3), dtype=np.float32)
    for axis in range(3):
        np.multiply(view.rays[:, axis], depth.ravel(), out=points[:, axis], casting="same_kind")
    rows = points.reshape(height, 3 * width)  # additions along short rows are slow
    rows += np.tile(view.extrinsics()[:3, 3].astype(np.float32), width)
    return points.reshape(height, width, 3)
