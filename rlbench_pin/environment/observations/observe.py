"""World and settings -> Observation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rlbench_pin.datasets.formats.rlbench import decode_mask
from rlbench_pin.environment.observations.cameras import CameraPlaces, Cameras
from rlbench_pin.environment.observations.config import (
    LOW_DIM_FIELDS,
    CameraConfig,
    Identity,
    Instant,
    ModelObservationConfig,
    ObservationConfig,
)
from rlbench_pin.errors import CameraError, TaskError, shown
from rlbench_pin.observation import LOW_DIM, Observation
from rlbench_pin.robot.collision import Distance
from rlbench_pin.robot.distances import DistanceModel
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.sim import CameraView, Images, Lighting, Request, World
from rlbench_pin.spatial import FloatArray, compose
from rlbench_pin.tasks import Task


def spread_mask(mask: np.ndarray) -> np.ndarray:
    """Spread ids over three channels, lowest byte first, as float32 in 0..1."""
    channels = np.stack([mask & 0xFF, (mask >> 8) & 0xFF, (mask >> 16) & 0xFF], axis=-1)
    return channels.astype(np.float32) / 255.0


def rgb_handles_to_mask(rgb: ArrayLike) -> np.ndarray:
    """Return the ids of a mask that is spread over three channels, the lowest byte first: r + 256 g + 65536 b.

    Args:
        rgb: The mask (..., 3): whole numbers in 0..255, as in a PNG file, or floats in 0..1, as with
            `masks_as_one_channel=False`. It is left as it is.

    Returns:
        Ids (...), int32.

    Raises:
        CameraError: It has another shape, or holds other numbers.
    """
    try:
        channels = np.asarray(rgb)
    except Exception as error:  # whatever objects raise that are no array
        raise CameraError(f"A mask over three channels is an array of numbers, not {shown(rgb)}.") from error
    if channels.ndim == 0 or channels.shape[-1] != 3 or channels.dtype.kind not in "uif":
        raise CameraError(f"A mask over three channels has shape (..., 3), not {channels.shape} of {channels.dtype}.")
    highest = 1 if channels.dtype.kind == "f" else 255
    if not np.all((channels >= 0) & (channels <= highest)):
        raise CameraError(f"The channels of a mask of {channels.dtype} lie in 0..{highest}; these do not.")
    return decode_mask(channels if highest == 255 else np.rint(channels * 255.0))


def boxed_settings(cameras: Sequence[str], image_size: tuple[int, int]) -> ObservationConfig:
    """Return settings that deliver all low-dimensional data and the colours of some cameras, and no more.

    Args:
        cameras: Whose images are wanted.
        image_size: Width and height [px].

    Raises:
        UnknownName: There is no such camera.
    """
    config = ObservationConfig()
    config.set_all(False)
    for name in LOW_DIM:
        setattr(config, name, True)
    for name in cameras:
        camera = config.camera(name)
        camera.rgb, camera.image_size = True, image_size
    return config


def boxed(name: str, value: object, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return numbers of an observation as float32, shape (n,), within their bounds.

    Numbers beyond a bound, which only an unstable simulation gives, are clipped. Fewer than there are bounds, as when a
    variation of a task has fewer objects, are filled up with zeros.

    Args:
        name: What they are.
        value: A number, or several.
        low: Lowest values, shape (n,).
        high: Highest values, shape (n,).

    Raises:
        TaskError: There are more numbers than bounds.
    """
    array = np.atleast_1d(np.asarray(value, dtype=np.float64))
    if len(array) > len(low):
        raise TaskError(f"'{name}' has grown to {len(array)} numbers; its space holds {len(low)}. A task state has one length.")
    if len(array) < len(low):
        array = np.concatenate([array, np.zeros(len(low) - len(array))])
    return np.clip(array, low, high).astype(np.float32)


class ModelObserver:
    """Computes the quantities of `ModelObservationConfig` for one world; keeps its distance model between observations.

    Args:
        world: Gives joint states and the places of all bodies.
        model: The arm.
    """

    def __init__(self, world: World, model: RobotModel) -> None:
        self._world, self._model = world, model
        self._distances: DistanceModel | None = None

    def observe(self, config: ModelObservationConfig) -> dict[str, Any]:
        """Return the wanted quantities by name."""
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
    """How images differ from the settings; domain randomization changes it."""

    lighting: Lighting | None = None
    """Takes the place of the lights of the settings."""
    offsets: dict[str, FloatArray] = field(default_factory=dict)
    """Pose (7,) of the moved camera in the frame of the camera of that name."""

    def change(self, lighting: Lighting | None = None, offsets: Mapping[str, FloatArray] | None = None) -> None:
        """Take other lights and offsets; without them, those of the settings."""
        self.lighting, self.offsets = lighting, dict(offsets or {})

    def moved(self, name: str, view: CameraView) -> CameraView:
        """Return the view of a camera with its offset."""
        return replace(view, pose=compose(view.pose, self.offsets[name])) if name in self.offsets else view


class Observer:
    """Makes observations of one world as one `ObservationConfig` asks.

    Args:
        world: The world to look at.
        model: Analytic model of its robot.
        config: What to deliver; read at each call, so changes take effect at once.
        places: Where cameras stand that were put elsewhere; nowhere when None.

    Attributes:
        config: The settings.
        appearance: How images differ from them.
    """

    def __init__(self, world: World, model: RobotModel, config: ObservationConfig, places: CameraPlaces | None = None) -> None:
        self._world, self._arm, self.config = world, model, config
        self.cameras = Cameras(world, model.description, config, places or CameraPlaces())
        self._model = ModelObserver(world, model)
        self.appearance = Appearance()

    def observe(self, task: Task, variation: int, rng: np.random.Generator, instructions: Sequence[str] = ()) -> Observation:
        """Return what is seen and felt now; every array is the caller's own."""
        observation = Observation(misc={"variation_index": variation, "descriptions": list(instructions)})
        instant = Instant(self._world, self._arm, task)
        for name, part in LOW_DIM_FIELDS.items():
            if getattr(self.config, name):
                value, noise = part.read(instant), self.config.noise_of(name)
                setattr(observation, name, value if noise is None else noise.apply(np.asarray(value), rng))
        if self.config.model.is_used:
            observation.misc.update(self._model.observe(self.config.model))
        if self.config.joint_poses:
            observation.misc["joint_poses"] = self._arm.joint_poses(self._world.robot.joint_positions)
        views = self._observe_cameras(observation, rng)
        if self.config.wrist_camera_matrix:
            observation.misc["wrist_camera_matrix"] = (views.get("wrist") or self._view("wrist")).extrinsics()
        return task.decorate_observation(observation)

    def _view(self, name: str) -> CameraView:
        """Return what a camera sees now, wherever it was put and however randomization moved it."""
        return self.appearance.moved(name, self.cameras.view(name))

    def _observe_cameras(self, observation: Observation, rng: np.random.Generator) -> dict[str, CameraView]:
        """Add what the cameras see, all of them at once, and return how they stand."""
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
            _add_images(observation, name, config, views[name], images, rng)
        return views


def _add_images(
    observation: Observation, name: str, config: CameraConfig, view: CameraView, images: Images, rng: np.random.Generator
) -> None:
    """Add what one camera delivers."""
    if images.rgb is not None:
        setattr(observation, f"{name}_rgb", _noisy_rgb(images.rgb, config, rng))
    if images.depth is not None:
        metres = config.noise_of("depth").apply(images.depth, rng)
        if config.point_cloud:
            setattr(observation, f"{name}_point_cloud", point_cloud(metres, view))
        if config.depth:
            setattr(observation, f"{name}_depth", metres if config.depth_in_meters else normalised_depth(metres, view))
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
    """World coordinates [m] of every pixel: extrinsics * inverse(intrinsics) * (u, v, 1) * depth.

    Args:
        depth: Metric depth along the optical axis, shape (h, w), [m].
        view: The camera that saw it.

    Returns:
        float32 array of shape (h, w, 3).
    """
    points = view.rays * depth.reshape(-1, 1)
    points += view.extrinsics()[:3, 3].astype(np.float32)
    return points.reshape(*depth.shape, 3)
