"""World and settings -> Observation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from rlbench_pin.environment.observations.config import LOW_DIM_FIELDS, CameraConfig, Instant, ObservationConfig
from rlbench_pin.environment.observations.masks import spread_mask
from rlbench_pin.environment.observations.model_based import ModelObserver
from rlbench_pin.environment.observations.noise import Identity
from rlbench_pin.environment.observations.placing import CameraPlaces, Cameras
from rlbench_pin.observation import Observation
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.sim import CameraView, Images, Lighting, Request, World
from rlbench_pin.spatial import FloatArray, compose
from rlbench_pin.tasks import Task


@dataclass
class Look:
    """How pictures differ from the settings; domain randomization changes it."""

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
        look: How pictures differ from them.
    """

    def __init__(self, world: World, model: RobotModel, config: ObservationConfig, places: CameraPlaces | None = None) -> None:
        self._world, self._arm, self.config = world, model, config
        self.cameras = Cameras(world, model.description, config, places or CameraPlaces())
        self._model = ModelObserver(world, model)
        self.look = Look()

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
        views = self._look(observation, rng)
        if self.config.wrist_camera_matrix:
            observation.misc["wrist_camera_matrix"] = (views.get("wrist") or self._view("wrist")).extrinsics()
        return task.decorate_observation(observation)

    def _view(self, name: str) -> CameraView:
        """Return what a camera sees now, wherever it was put and however randomization moved it."""
        return self.look.moved(name, self.cameras.view(name))

    def _look(self, observation: Observation, rng: np.random.Generator) -> dict[str, CameraView]:
        """Add what the cameras see, all of them at once, and return how they stand."""
        renderer = self._world.renderer
        renderer.lighting = self.look.lighting or self.config.lighting
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
        for (name, config), pictures in zip(cameras.items(), renderer.render_all(requests), strict=True):
            _add_pictures(observation, name, config, views[name], pictures, rng)
        return views


def _add_pictures(
    observation: Observation, name: str, config: CameraConfig, view: CameraView, pictures: Images, rng: np.random.Generator
) -> None:
    """Add what one camera delivers."""
    if pictures.rgb is not None:
        setattr(observation, f"{name}_rgb", _noisy_rgb(pictures.rgb, config, rng))
    if pictures.depth is not None:
        metres = config.noise_of("depth").apply(pictures.depth, rng)
        if config.point_cloud:
            setattr(observation, f"{name}_point_cloud", point_cloud(metres, view))
        if config.depth:
            setattr(observation, f"{name}_depth", metres if config.depth_in_meters else normalised_depth(metres, view))
    if pictures.mask is not None:
        setattr(observation, f"{name}_mask", pictures.mask if config.masks_as_one_channel else spread_mask(pictures.mask))
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
