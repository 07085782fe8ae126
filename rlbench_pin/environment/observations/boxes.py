"""Observations as gymnasium's environments deliver them: numbers within bounds, float32, and pictures as they are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rlbench_pin.environment.observations.config import ObservationConfig
from rlbench_pin.errors import TaskError
from rlbench_pin.observation import LOW_DIM


def boxed_settings(cameras: Sequence[str], image_size: tuple[int, int]) -> ObservationConfig:
    """Return settings that deliver all low-dimensional data and the colours of some cameras, and no more.

    Args:
        cameras: Whose pictures are wanted.
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


__all__ = ["boxed", "boxed_settings"]
