"""Conversion between float arrays and images, masks by handle, and task classes by name.

A colour image encodes each number times a scale in 24 bits: red, green and blue, with red as the most significant byte.
"""

from __future__ import annotations

import importlib

import numpy as np
from PIL import Image

from rlbench_pin.environment import rgb_handles_to_mask
from rlbench_pin.errors import CameraError
from rlbench_pin.tasks.registry import camel_case

DEFAULT_RGB_SCALE_FACTOR = 256000.0
"""Default scale of colour images: number of steps from 0.0 to 1.0."""
DEFAULT_GRAY_SCALE_FACTOR = {np.uint8: 100.0, np.uint16: 1000.0, np.int32: DEFAULT_RGB_SCALE_FACTOR}
"""Default scales of images with one channel, by the type of their numbers."""
_HIGHEST = 2**24 - 1
_GRAY_MODES = {np.dtype(np.uint8): np.uint8, np.dtype(np.uint16): np.uint16, np.dtype(np.int32): np.int32}


def task_file_to_task_class(task_file: str) -> type:
    """Return the class of a task for the name of its file, with or without `.py`."""
    name = task_file.removesuffix(".py")
    found: type = getattr(importlib.import_module(f"rlbench.tasks.{name}"), camel_case(name))
    return found


def ClipFloatValues(float_array: np.ndarray, min_value: float, max_value: float) -> np.ndarray:
    """Return an array with its numbers clipped to `min_value` and `max_value`; NaN becomes `min_value`."""
    array = np.nan_to_num(np.asarray(float_array, dtype=np.float64), nan=min_value, posinf=max_value, neginf=min_value)
    return np.clip(array, min_value, max_value)


def float_array_to_rgb_image(
    float_array: np.ndarray, scale_factor: float | None = DEFAULT_RGB_SCALE_FACTOR, drop_blue: bool = False
) -> Image.Image:
    """Encode numbers (h, w) in the 24 bits of a colour image; numbers out of range are clipped.

    With `scale_factor=rlbench.backend.const.DEPTH_SCALE`, depth from 0 to 1 gives the same image as in stored demonstrations.

    Args:
        float_array: The numbers, shape (h, w), not negative.
        scale_factor: Number of steps from 0.0 to 1.0; None is the default scale.
        drop_blue: Set the least significant channel to 0.
    """
    scale = DEFAULT_RGB_SCALE_FACTOR if scale_factor is None else scale_factor
    array = _plane(float_array)
    steps = np.rint(ClipFloatValues(array.astype(np.float64) * scale, 0.0, _HIGHEST)).astype(np.uint32)
    blue = np.zeros_like(steps) if drop_blue else steps & 255
    return Image.fromarray(np.stack([steps >> 16, steps >> 8 & 255, blue], axis=-1).astype(np.uint8), mode="RGB")


def float_array_to_grayscale_image(
    float_array: np.ndarray, scale_factor: float | None = None, image_dtype: type = np.uint8
) -> Image.Image:
    """Encode numbers (h, w) in an image with one channel; numbers out of range are clipped.

    Args:
        float_array: The numbers, shape (h, w), not negative.
        scale_factor: Number of steps from 0.0 to 1.0; by default 100 for uint8, 1000 for uint16, 256000 for int32.
        image_dtype: Type of the numbers in the image, one of these three.

    Raises:
        CameraError: `image_dtype` is another type.
    """
    kind = _GRAY_MODES.get(np.dtype(image_dtype))
    if kind is None:
        raise CameraError(f"An image with one channel has to have the type uint8, uint16 or int32, not {image_dtype}.")
    scale = DEFAULT_GRAY_SCALE_FACTOR[kind] if scale_factor is None else scale_factor
    highest = float(np.iinfo(str(np.dtype(kind))).max)
    steps = np.rint(ClipFloatValues(_plane(float_array).astype(np.float64) * scale, 0.0, highest))
    return Image.fromarray(steps.astype(kind))


def image_to_float_array(image: Image.Image | np.ndarray, scale_factor: float | None = None) -> np.ndarray:
    """Decode an image of one of the two kinds: return its numbers (h, w), float32.

    Args:
        image: The image, or its values (h, w, 3) or (h, w).
        scale_factor: Scale of the encoding; None is the default of this kind of image.

    Raises:
        CameraError: The image has neither one nor three channels.
    """
    array = np.asarray(image)
    if array.ndim == 3 and array.shape[2] >= 3:
        red, green, blue = (array[..., i].astype(np.uint32) for i in range(3))
        scale = DEFAULT_RGB_SCALE_FACTOR if scale_factor is None else scale_factor
        return np.asarray((red << 16 | green << 8 | blue) / scale, dtype=np.float32)
    if array.ndim == 3 and array.shape[2] == 1:
        array = array[..., 0]
    kind = _GRAY_MODES.get(array.dtype)
    if array.ndim != 2 or kind is None:
        raise CameraError(
            f"An encoded image has to have one or three channels of whole numbers, not {array.shape} {array.dtype}."
        )
    scale = DEFAULT_GRAY_SCALE_FACTOR[kind] if scale_factor is None else scale_factor
    return np.asarray(array / scale, dtype=np.float32)


def _plane(float_array: np.ndarray) -> np.ndarray:
    """Return an array (h, w) or (h, w, 1) with shape (h, w)."""
    array = np.asarray(float_array)
    if array.ndim == 3 and array.shape[2] == 1:
        array = array[..., 0]
    if array.ndim != 2:
        raise CameraError(f"The array to encode as an image has to have shape (h, w), not {array.shape}.")
    return array


__all__ = [
    "DEFAULT_GRAY_SCALE_FACTOR",
    "DEFAULT_RGB_SCALE_FACTOR",
    "ClipFloatValues",
    "float_array_to_grayscale_image",
    "float_array_to_rgb_image",
    "image_to_float_array",
    "rgb_handles_to_mask",
    "task_file_to_task_class",
]
