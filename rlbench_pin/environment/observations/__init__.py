"""What observations contain: settings, cameras, noise, and how a world becomes an observation."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.environment.observations.camera_config import CameraConfig
from rlbench_pin.environment.observations.cameras import camera_view
from rlbench_pin.environment.observations.config import ObservationConfig
from rlbench_pin.environment.observations.extra_cameras import ExtraCamera
from rlbench_pin.environment.observations.masks import rgb_handles_to_mask
from rlbench_pin.environment.observations.model_based import ModelObservationConfig
from rlbench_pin.environment.observations.noise import GaussianNoise, Identity, NoiseModel
from rlbench_pin.environment.observations.observe import Observer
from rlbench_pin.environment.observations.placing import Camera, CameraPlaces, Cameras
from rlbench_pin.front_door import front_door

__all__ = [
    "Camera",
    "CameraConfig",
    "CameraPlaces",
    "Cameras",
    "ExtraCamera",
    "GaussianNoise",
    "Identity",
    "ModelObservationConfig",
    "NoiseModel",
    "ObservationConfig",
    "Observer",
    "camera_view",
    "rgb_handles_to_mask",
]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
