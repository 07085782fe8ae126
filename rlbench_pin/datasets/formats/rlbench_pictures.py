"""Colours, depth and masks as the PNG files of RLBench-style folders."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image, UnidentifiedImageError

from rlbench_pin.errors import DatasetError, EpisodeFileError

DEPTH_STEPS = 2**24 - 1
"""Depth 0..1 is stored in so many steps: 0.3 micrometres of 4.5 m."""


def encode_depth(depth: np.ndarray) -> np.ndarray:
    """Spread depth (h, w) in 0..1 over three bytes (h, w, 3), the first the most significant."""
    if not np.all((depth >= 0.0) & (depth <= 1.0)):
        raise DatasetError("Depth must lie in 0..1 to become a picture. Record with depth_in_meters=False.")
    steps = np.rint(depth.astype(np.float64) * DEPTH_STEPS).astype(np.uint32)
    return np.stack([steps >> 16, steps >> 8 & 255, steps & 255], axis=-1).astype(np.uint8)


def decode_depth(picture: np.ndarray) -> np.ndarray:
    """Return depth (h, w) in 0..1, float32."""
    r, g, b = (picture[..., i].astype(np.uint32) for i in range(3))
    return ((r << 16 | g << 8 | b) / DEPTH_STEPS).astype(np.float32)


def encode_mask(mask: np.ndarray) -> np.ndarray:
    """Spread ids (h, w) over three bytes (h, w, 3), the first the least significant."""
    ids = mask.astype(np.int64)
    if np.any((ids < 0) | (ids >= 2**24)):
        raise DatasetError("Ids of a mask must lie in 0..2^24 - 1 to become a picture.")
    return np.stack([ids & 255, ids >> 8 & 255, ids >> 16], axis=-1).astype(np.uint8)


def spread_bytes(mask: np.ndarray) -> np.ndarray:
    """Return a mask over three channels (h, w, 3), floats in 0..1 or whole numbers in 0..255, as bytes."""
    return np.rint(mask * 255.0 if mask.dtype.kind == "f" else mask).astype(np.uint8)


def decode_mask(picture: np.ndarray) -> np.ndarray:
    """Return ids (h, w), int32."""
    r, g, b = (picture[..., i].astype(np.int32) for i in range(3))
    return r | g << 8 | b << 16


def write_png(path: Path, picture: np.ndarray) -> None:
    """Write (h, w, 3) bytes."""
    Image.fromarray(np.ascontiguousarray(picture)).save(path, compress_level=6)


def read_png(path: Path) -> np.ndarray:
    """Read (h, w, 3) bytes.

    Raises:
        EpisodeFileError: The file is missing or damaged.
    """
    try:
        with Image.open(path) as image:
            return np.array(image.convert("RGB"))
    except (OSError, UnidentifiedImageError, SyntaxError, Image.DecompressionBombError) as error:
        raise EpisodeFileError(path, f"The picture '{path}' is missing or damaged ({error}).") from error
