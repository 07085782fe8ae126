"""Shadows, fill lights and textures on what a camera sees."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.render.backdrop import Backdrop
from rlbench_pin.sim.render.camera import CameraView
from rlbench_pin.sim.render.lighting import Lighting
from rlbench_pin.sim.render.link_texture import LinkTexture, colors_of
from rlbench_pin.sim.render.masks import segment_of
from rlbench_pin.sim.render.shadows import LightSpots, ShadowMap, spots_in_picture, spots_of
from rlbench_pin.sim.render.shots import Shot

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
    """Points of moving things that one camera sees, in its frame; each quantity as x, y and z."""

    backdrop: KeptBackdrop
    """The camera."""
    shot: Shot
    """What it sees."""
    points: NDArray[np.float32]
    """(3, n) [m]."""
    normals: NDArray[np.float32]
    """Unit normals (3, n)."""

    def in_world(self, chosen: NDArray[np.int64]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return some points and normals (m, 3) in world axes."""
        pose = self.backdrop.view.extrinsics().astype(np.float32)
        points, normals = (a[:, chosen].T @ pose[:3, :3].T for a in (self.points, self.normals))
        return points + pose[:3, 3], normals


def surfaces_of(backdrop: KeptBackdrop, shot: Shot) -> Surfaces:
    """Find the points and normals of what a camera sees, from its depth.

    On a plane m . P = 1 the inverse depth is m . ray, affine over the picture; its slopes therefore give m. At edges the smaller
    of the two one-sided slopes is that of the surface itself.
    """
    view = backdrop.view
    width = view.size[0]
    row, column = np.divmod(shot.pixels.astype(np.int32), np.int32(width))
    place = shot.pixels + 2 * row
    place += width + 3
    inverse = backdrop.inverse.copy()
    inverse[place] = here = shot.inverse
    along = _smaller(inverse.take(place + 1) - here, here - inverse.take(place - 1))
    down = _smaller(inverse.take(place + (width + 2)) - here, here - inverse.take(place - (width + 2)))
    k = view.intrinsics().astype(np.float32)
    u, v = column.astype(np.float32) - k[0, 2], row.astype(np.float32) - k[1, 2]
    normals, points = np.empty((3, len(here)), dtype=np.float32), np.empty((3, len(here)), dtype=np.float32)
    np.multiply(along, -k[0, 0], out=normals[0])
    np.multiply(down, -k[1, 1], out=normals[1])
    np.subtract(along * u + down * v, here, out=normals[2])
    length = normals[0] * normals[0]
    length += normals[1] * normals[1]
    length += normals[2] * normals[2]
    normals /= np.maximum(np.sqrt(length, out=length), np.float32(1e-12), out=length)
    np.multiply(u, shot.depth / k[0, 0], out=points[0])
    np.multiply(v, shot.depth / k[1, 1], out=points[1])
    points[2] = shot.depth
    return Surfaces(backdrop, shot, points, normals)


def _smaller(a: NDArray[np.float32], b: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.where(np.abs(a) < np.abs(b), a, b)


def brightness(surfaces: Surfaces, lighting: Lighting, shadows: ShadowMap) -> NDArray[np.float32]:
    """By how much brighter (n, 1) or (n, 3) points are than ambient and unshaded key light make them."""
    turn = surfaces.backdrop.view.extrinsics()[:3, :3]
    cosine = _on(surfaces.normals, lighting.key.unit @ turn)
    key = cosine * np.float32(lighting.key.intensity)
    ambient = np.float32(lighting.ambient)
    plain = ambient + key
    if not shadows.is_empty:
        key *= _share(surfaces, cosine, shadows)
    fills = [_on(surfaces.normals, fill.unit @ turn) * np.float32(fill.intensity) for fill in lighting.fills]
    if lighting.is_white:
        key += ambient
        for fill in fills:
            key += fill
        key /= plain
        return key[:, None]
    tint = np.array(lighting.key.color, dtype=np.float32)
    mixed = ambient * (tint * np.float32(0.5) + np.float32(0.5)) + key[:, None] * tint
    for fill, light in zip(fills, lighting.fills, strict=True):
        mixed += fill[:, None] * np.array(light.color, dtype=np.float32)
    return mixed / plain[:, None]


def _share(surfaces: Surfaces, cosine: NDArray[np.float32], shadows: ShadowMap) -> NDArray[np.float32]:
    """Share (n,) of the key light that reaches points; surfaces that it grazes are given more room."""
    tangent = np.sqrt(np.float32(1.0) - np.minimum(cosine, np.float32(1.0)) ** 2) / np.maximum(cosine, np.float32(0.15))
    tangent *= np.float32(0.008)
    tangent += np.float32(0.006)
    return shadows.lit(spots_of(shadows.view, surfaces.backdrop.view, surfaces.points), tangent)


def _on(normals: NDArray[np.float32], direction: NDArray[np.float64]) -> NDArray[np.float32]:
    """Cosines (n,) between normals (3, n) and a unit vector (3,), 0 where they point away from each other."""
    x, y, z = direction.astype(np.float32)
    cosine = normals[0] * x
    cosine += normals[1] * y
    cosine += normals[2] * z
    return np.maximum(cosine, np.float32(0.0), out=cosine)


def put_textures(
    colors: NDArray[np.float32], surfaces: Surfaces, textures: Mapping[tuple[int, int], LinkTexture], frame: LinkFrame
) -> None:
    """Multiply colours (n, 3) by textures of links.

    Args:
        colors: Colours of the points.
        surfaces: The points.
        textures: Textures by body and link.
        frame: Says where a link is.
    """
    shot, focal = surfaces.shot, np.float32(-surfaces.backdrop.view.intrinsics()[0, 0])
    for (body, link), texture in textures.items():
        chosen = np.flatnonzero(shot.segments == segment_of(body, link))
        if len(chosen):
            points, normals = surfaces.in_world(chosen)
            colors[chosen] *= colors_of(texture, frame(body, link), points, normals, shot.depth[chosen] / focal)


def as_bytes(colors: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Round colours in 0..255; overwrites them."""
    colors += np.float32(0.5)
    return np.minimum(colors, np.float32(255.0), out=colors).astype(np.uint8)


def _unpacked(colors: NDArray[np.uint32]) -> NDArray[np.float32]:
    """Colours (n, 3) in 0..255 of rgba bytes in one number."""
    return colors.view(np.uint8).reshape(-1, 4)[:, :3].astype(np.float32)
