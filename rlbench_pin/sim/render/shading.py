"""Shadows of moving things on the room."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.render.backdrop import PIXEL, Backdrop
from rlbench_pin.sim.render.camera import CameraView
from rlbench_pin.sim.render.shadows import LightSpots, ShadowMap, joined_spots, spots_in_picture

_EDGE = np.float32(1e9)


class KeptBackdrop:
    """The room as one camera sees it, and what follows from that alone.

    Args:
        view: The camera.
        picture: What it sees of the room.
    """

    def __init__(self, view: CameraView, picture: Backdrop) -> None:
        self.view, self.picture = view, picture
        self._spots: tuple[CameraView, LightSpots] | None = None
        self._was_shaded = False

    @cached_property
    def inverse(self) -> NDArray[np.float32]:
        """Inverse depth [1/m] with one more pixel on every side, ((h + 2) * (w + 2),)."""
        height, width = self.picture.depth.shape
        padded = np.full((height + 2, width + 2), _EDGE, dtype=np.float32)
        np.divide(np.float32(1.0), self.picture.depth, out=padded[1:-1, 1:-1])
        return padded.ravel()

    def spots(self, light: CameraView) -> LightSpots:
        """Where its pixels lie in the picture that the key light takes."""
        if self._spots is None or self._spots[0] is not light:
            self._spots = light, spots_in_picture(light, self.view, self.picture.depth)
        return self._spots[1]

    def dark(self, pixels: NDArray[np.int64]) -> NDArray[np.void]:
        """Colours (n,), of type `PIXEL`, of some pixels in the shadow of the key light; from the second time on all are kept."""
        if self._was_shaded:
            return self.picture.all_dark.take(pixels)
        self._was_shaded = True
        return self.picture.dark(pixels)


def shade_rooms(images: Sequence[NDArray[np.uint8]], backdrops: Sequence[KeptBackdrop], shadows: ShadowMap) -> None:
    """Darken the room in images (h, w, 3) where moving things stand in the key light.

    Args:
        images: The pictures, of all cameras.
        backdrops: The room as these cameras see it.
        shadows: The shadows.
    """
    if shadows.is_empty or not images:
        return
    spots = [backdrop.spots(shadows.view) for backdrop in backdrops]
    near = [shadows.is_near.take(each.texel).nonzero()[0] for each in spots]
    share = shadows.lit(joined_spots([each.at(pixels) for each, pixels in zip(spots, near, strict=True)]))
    ends = np.cumsum([0, *(len(pixels) for pixels in near)])
    shaded = (share < 1.0).nonzero()[0]
    parts = np.searchsorted(shaded, ends)
    chosen = [pixels.take(shaded[a:b] - end) for pixels, a, b, end in zip(near, parts, parts[1:], ends)]
    colors = np.concatenate([backdrop.dark(pixels) for backdrop, pixels in zip(backdrops, chosen, strict=True)])
    share = share.take(shaded)
    between = (share > 0.0).nonzero()[0]
    high = np.concatenate([image.reshape(-1).view(PIXEL).take(pixels) for image, pixels in zip(images, chosen, strict=True)])
    colors[between] = _mixed(colors.take(between), high.take(between), share.take(between)).reshape(-1).view(PIXEL)
    for image, pixels, a, b in zip(images, chosen, parts, parts[1:]):
        image.reshape(-1).view(PIXEL)[pixels] = colors[a:b]


def darken_feet(image: NDArray[np.uint8], backdrop: KeptBackdrop, shadows: ShadowMap) -> None:
    """Darken the table in an image (h, w, 3) around the feet of what stands on it."""
    if shadows.is_empty:
        return
    spots = backdrop.spots(shadows.view)
    pixels = shadows.is_dim.take(spots.texel).nonzero()[0]
    colors = image.reshape(-1, 3).take(pixels, axis=0).T * shadows.open(spots.at(pixels))
    put_pixels(image, pixels, as_bytes(colors))


def put_pixels(image: NDArray[np.uint8], pixels: NDArray[np.int64], colors: NDArray[np.uint8]) -> None:
    """Write colours (n, 3) to some pixels, by flat index, of an image (h, w, 3)."""
    image.reshape(-1).view(PIXEL)[pixels] = np.ascontiguousarray(colors).reshape(-1).view(PIXEL)


def as_bytes(colors: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Colours (n, 3) of those in 0..255, (3, n), rounded; overwrites them."""
    colors += np.float32(0.5)
    np.minimum(colors, np.float32(255.0), out=colors)
    result = np.empty((colors.shape[1], 3), dtype=np.uint8)
    for channel, values in enumerate(colors):
        result[:, channel] = values.astype(np.uint8)
    return result


def halved(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """An image (h, w, 3) of the means of two by two pixels of one of twice the size."""
    sums = image[:, 0::2].astype(np.uint16)
    sums += image[:, 1::2]
    pairs = sums[0::2]
    pairs += sums[1::2]
    pairs += np.uint16(2)
    pairs >>= np.uint16(2)
    return pairs.astype(np.uint8)


def _mixed(low: NDArray[np.void], high: NDArray[np.void], share: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Colours (n, 3) between those of two arrays (n,) of type `PIXEL`."""
    colors = np.empty((3, len(share)), dtype=np.float32)
    first, last = low.view(np.uint8).reshape(-1, 3), high.view(np.uint8).reshape(-1, 3)
    for channel, values in enumerate(colors):
        start = first[:, channel].astype(np.float32)
        np.subtract(last[:, channel], start, out=values)
        values *= share
        values += start
    return as_bytes(colors)
