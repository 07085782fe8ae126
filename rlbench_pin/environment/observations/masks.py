"""Masks over three channels, and back to ids."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rlbench_pin.datasets.formats.rlbench import decode_mask
from rlbench_pin.errors import CameraError, shown


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
