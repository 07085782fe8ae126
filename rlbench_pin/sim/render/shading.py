"""Shadows, fill lights and textures on what cameras see, for all of them at once: small arrays cost mostly their calls."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.render.backdrop import Backdrop
from rlbench_pin.sim.render.camera import CameraView
from rlbench_pin.sim.render.lighting import Lighting
from rlbench_pin.sim.render.link_texture import LinkTexture, colors_of
from rlbench_pin.sim.render.shadows import LightSpots, ShadowMap, spots_in_picture, spots_of
from rlbench_pin.sim.render.shots import LINK_SHIFT, Shot

_EDGE = np.float32(1e9)
LinkFrame = Callable[[int, int], NDArray[np.float32]]
"""Returns the placement (4, 4) of a link in the world, by body and link."""


class KeptBackdrop:
    """The room as one camera sees it, and what follows from that alone.

    Args:
        view: The camera.
        picture: What it sees of the room.
    """

    def __init__(self, view: CameraView, picture: Backdrop) -> None:
        self.view, self.picture = view, picture
        self._spots: tuple[CameraView, LightSpots] | None = None

    @cached_property
    def rgb(self) -> NDArray[np.uint8]:
        """Colours (h, w, 3) where the key light reaches everything."""
        height, width = self.picture.lit.shape
        return np.ascontiguousarray(self.picture.lit.view(np.uint8).reshape(height, width, 4)[..., :3])

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


def shade_room(image: NDArray[np.uint8], backdrop: KeptBackdrop, shadows: ShadowMap) -> None:
    """Darken the room in an image (h, w, 3) where moving things stand in the key light."""
    spots = backdrop.spots(shadows.view)
    pixels = np.flatnonzero(shadows.is_near[spots.first])
    share = shadows.lit(spots.at(pixels))
    shaded = np.flatnonzero(share < 1.0)
    pixels, share = pixels[shaded], share[shaded]
    low, high = (_unpacked(colors.ravel()[pixels]) for colors in (backdrop.picture.dark, backdrop.picture.lit))
    image.reshape(-1, 3)[pixels] = as_bytes(low + (high - low) * share[:, None])


@dataclass(frozen=True, eq=False)
class Surfaces:
    """Points of moving things that some cameras see, those of one camera after those of the other."""

    shots: tuple[Shot, ...]
    """What the cameras see."""
    points: NDArray[np.float32]
    """Where it is (3, n) in the world [m]."""
    normals: NDArray[np.float32]
    """Unit normals (3, n) in the world."""


def surfaces_of(backdrops: Sequence[KeptBackdrop], shots: Sequence[Shot]) -> Surfaces:
    """Find the points and normals of what cameras see, from its depth.

    On a plane m . P = 1 the inverse depth is m . ray, affine over the picture; its slopes therefore give m. At edges the smaller
    of the two one-sided slopes is that of the surface itself.
    """
    parts = [_surface(backdrop, shot) for backdrop, shot in zip(backdrops, shots, strict=True)]
    return Surfaces(tuple(shots), *(np.concatenate([part[i] for part in parts], axis=1) for i in (0, 1)))


def _surface(backdrop: KeptBackdrop, shot: Shot) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Points and normals (3, n) of one shot."""
    view = backdrop.view
    width = view.size[0]
    row, column = np.divmod(shot.pixels.astype(np.int32), np.int32(width))
    place = shot.pixels + 2 * row + (width + 3)
    inverse = backdrop.inverse.copy()
    inverse[place] = here = shot.inverse
    along = _smaller(inverse[place + 1] - here, here - inverse[place - 1])
    down = _smaller(inverse[place + width + 2] - here, here - inverse[place - width - 2])
    k, pose = view.intrinsics().astype(np.float32), view.extrinsics().astype(np.float32)
    u, v = column.astype(np.float32) - k[0, 2], row.astype(np.float32) - k[1, 2]
    normals = _turned(pose, -along * k[0, 0], -down * k[1, 1], along * u + down * v - here)
    length = np.sqrt(normals[0] * normals[0] + normals[1] * normals[1] + normals[2] * normals[2])
    normals /= np.maximum(length, np.float32(1e-12))
    points = _turned(pose, u * (shot.depth / k[0, 0]), v * (shot.depth / k[1, 1]), shot.depth)
    points += pose[:3, 3:]
    return points, normals


def _smaller(a: NDArray[np.float32], b: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.where(np.abs(a) < np.abs(b), a, b)


def _turned(pose: NDArray[np.float32], x: NDArray, y: NDArray, z: NDArray) -> NDArray[np.float32]:
    """Vectors (3, n) in the world from their components in a frame (4, 4)."""
    return pose[:3, :1] * x + pose[:3, 1:2] * y + pose[:3, 2:3] * z


def light_factors(surfaces: Surfaces, lighting: Lighting, shadows: ShadowMap) -> NDArray[np.float32]:
    """By how much brighter (n, 3) or (n, 1) points are than ambient and unshaded key light make them."""
    normals = surfaces.normals
    cosine = _on(normals, lighting.key.unit)
    tangent = np.sqrt(np.float32(1.0) - np.minimum(cosine, np.float32(1.0)) ** 2) / np.maximum(cosine, np.float32(0.15))
    bias = np.float32(0.006) + np.float32(0.008) * tangent
    lit = np.float32(1.0) if shadows.is_empty else shadows.lit(spots_of(shadows.view, surfaces.points), bias)
    key = cosine * np.float32(lighting.key.intensity)
    ambient = np.float32(lighting.ambient)
    plain = ambient + key
    fills = [_on(normals, fill.unit) * np.float32(fill.intensity) for fill in lighting.fills]
    if lighting.is_white:
        total = ambient + key * lit
        for fill in fills:
            total += fill
        return (total / plain)[:, None]
    tint = np.array(lighting.key.color, dtype=np.float32)
    mixed = ambient * (tint * np.float32(0.5) + np.float32(0.5)) + (key * lit)[:, None] * tint
    for fill, light in zip(fills, lighting.fills, strict=True):
        mixed = mixed + fill[:, None] * np.array(light.color, dtype=np.float32)
    return mixed / plain[:, None]


def _on(normals: NDArray[np.float32], direction: NDArray[np.float64]) -> NDArray[np.float32]:
    """Cosines (n,) between normals (3, n) and a unit vector (3,), 0 where they point away from each other."""
    x, y, z = direction.astype(np.float32)
    return np.maximum(normals[0] * x + normals[1] * y + normals[2] * z, np.float32(0.0))


def put_textures(
    colors: NDArray[np.float32],
    backdrops: Sequence[KeptBackdrop],
    surfaces: Surfaces,
    textures: Mapping[tuple[int, int], LinkTexture],
    frame: LinkFrame,
) -> None:
    """Multiply colours (n, 3) by textures of links.

    Args:
        colors: Colours of the points.
        backdrops: The cameras.
        surfaces: The points.
        textures: Textures by body and link.
        frame: Says where a link is.
    """
    shots = surfaces.shots
    segments = np.concatenate([shot.segments for shot in shots])
    sizes = [shot.depth / np.float32(-b.view.intrinsics()[0, 0]) for b, shot in zip(backdrops, shots, strict=True)]
    size = np.concatenate(sizes)
    for (body, link), texture in textures.items():
        chosen = np.flatnonzero(segments == body + ((link + 1) << LINK_SHIFT))
        if len(chosen):
            points, normals = (np.ascontiguousarray(a[:, chosen].T) for a in (surfaces.points, surfaces.normals))
            colors[chosen] *= colors_of(texture, frame(body, link), points, normals, size[chosen])


def as_bytes(colors: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Round colours in 0..255."""
    return np.minimum(colors + np.float32(0.5), np.float32(255.0)).astype(np.uint8)


def _unpacked(colors: NDArray[np.uint32]) -> NDArray[np.float32]:
    """Colours (n, 3) in 0..255 of rgba bytes in one number."""
    return colors.view(np.uint8).reshape(-1, 4)[:, :3].astype(np.float32)
