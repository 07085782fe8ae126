"""Textures: images made square, with mipmap levels against flicker on far surfaces."""

from __future__ import annotations

import copy
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from rlbench_pin.errors import CameraError

_LARGEST = 512  # [px]


class Texture:
    """A repeating square image, with all its mipmap levels in one array of texels.

    Args:
        pixels: uint8 (h, w, 3); resampled to a power of two up to 512.

    Attributes:
        size: Side of the finest level [px].
        texels: float32 (n, 3) in 0..1, finest level first.
    """

    def __init__(self, pixels: NDArray[np.uint8]) -> None:
        side = min(_LARGEST, 1 << int(np.ceil(np.log2(max(pixels.shape[:2])))))
        if pixels.shape[:2] != (side, side):
            pixels = np.asarray(Image.fromarray(pixels).resize((side, side), Image.Resampling.BILINEAR))
        level = pixels.astype(np.float32) / 255.0
        levels = [level]
        while level.shape[0] > 1:
            level = (level[0::2, 0::2] + level[1::2, 0::2] + level[0::2, 1::2] + level[1::2, 1::2]) / 4.0
            levels.append(level)
        self.size = side
        self.texels: NDArray[np.float32] = np.concatenate([level.reshape(-1, 3) for level in levels])
        self._sides = np.array([level.shape[0] for level in levels], dtype=np.int32)
        self._float_sides, self._lasts = self._sides.astype(np.float32), self._sides - 1
        self._starts = np.concatenate([[0], np.cumsum(self._sides**2)[:-1]]).astype(np.int32)

    @cached_property
    def gray(self) -> Texture:
        """The same pattern in grey, as a factor for a colour."""
        shades = self.texels.mean(axis=1, keepdims=True)
        low, high = float(shades.min()), float(shades.max())
        twin = copy.copy(self)
        twin.__dict__.pop("gray", None)
        twin.texels = np.repeat(0.7 + 0.3 * (shades - low) / max(high - low, 1e-3), 3, axis=1).astype(np.float32)
        return twin

    @cached_property
    def relative(self) -> NDArray[np.float32]:
        """Its texels (3, n) over their mean."""
        return np.ascontiguousarray((self.texels / np.maximum(self.mean, 1e-3)).T)

    @property
    def mean(self) -> NDArray[np.float32]:
        """Mean colour (3,)."""
        return self.texels[-1]

    def indices(self, u: NDArray, v: NDArray, texels_per_pixel: NDArray) -> NDArray[np.int32]:
        """Rows of `texels` for texture coordinates; v increases upwards, the top row of the image is v = 1.

        Args:
            u: Horizontal coordinate (n,), repeating with period 1.
            v: Vertical coordinate (n,).
            texels_per_pixel: Texels of the finest level that one pixel covers (n,); selects the level.
        """
        # the exponent of a number of at least 1 is its logarithm to base 2, rounded down
        level = np.maximum(texels_per_pixel, np.float32(1.0)).astype(np.float32, copy=False).view(np.int32) >> 23
        level -= 127
        np.minimum(level, len(self._sides) - 1, out=level)
        lowest, highest = (int(level.min()), int(level.max())) if len(level) else (0, 0)
        chosen: NDArray[np.int32] | int = lowest if lowest == highest else level
        sides, last, start = (values.take(chosen) for values in (self._float_sides, self._lasts, self._starts))
        column, row = u * sides, v * -sides
        column = np.floor(column, out=column).astype(np.int32)
        row = np.floor(row, out=row).astype(np.int32)
        column &= last
        row &= last
        row *= last + np.int32(1)
        row += column
        row += start
        return row


@lru_cache(maxsize=32)
def shaded_texture(path: Path | None, share: float, tint: tuple[float, float, float]) -> Texture:
    """Return a pattern as a factor for colours: an image relative to its mean brightness, mixed with white, times a tint.

    Args:
        path: The image; None gives a plain texture.
        share: Share of the image in the mix: 0 is plain, 1 is the image only.
        tint: Factor of red, green and blue.
    """
    plain = Texture(np.full((1, 1, 3), 255, dtype=np.uint8))
    twin = copy.copy(plain if path is None else read_texture(path))
    twin.__dict__.pop("gray", None)
    twin.__dict__.pop("relative", None)
    brightness = max(float(twin.mean.mean()), 1e-3)
    mixed = 1.0 + share * (twin.texels / brightness - 1.0) if path is not None else twin.texels
    twin.texels = np.minimum(mixed * np.array(tint), 1.6).astype(np.float32)
    return twin


@lru_cache(maxsize=64)
def read_texture(path: Path) -> Texture:
    """Read an image file.

    Raises:
        CameraError: It is missing or not an image.
    """
    try:
        with Image.open(path) as image:
            return Texture(np.asarray(image.convert("RGB")))
    except (OSError, UnidentifiedImageError, ValueError) as error:
        raise CameraError(f"The texture '{path}' cannot be read as an image: {error}. Name an image file.") from error
