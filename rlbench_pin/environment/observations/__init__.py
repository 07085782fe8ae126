"""Observations: settings, cameras, noise, and the observer of a world."""

from rlbench_pin.environment.observations.config import (
    CameraConfig,
    ExtraCamera,
    GaussianNoise,
    Identity,
    ModelObservationConfig,
    NoiseModel,
    ObservationConfig,
)
from rlbench_pin.environment.observations.observe import Camera, Cameras, Observer, camera_view, rgb_handles_to_mask

__all__ = [
    "Camera",
    "CameraConfig",
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
