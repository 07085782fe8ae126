"""Light, shadows and textures on the room and on moving objects.

Textures on moving objects are projected along the main axes of each link, whatever its mesh says.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.render.backdrop import PIXEL, Backdrop
from rlbench_pin.sim.render.camera import CameraView
from rlbench_pin.sim.render.lighting import (
    SPECULAR,
    Light,
    Lighting,
    LightSpots,
    ShadowMap,
    TableSpots,
    joined_spots,
    spots_of,
    table_spots,
)
from rlbench_pin.sim.render.masks import segment_of
from rlbench_pin.sim.render.raster.stage import Lamp
from rlbench_pin.sim.render.shots import Shot
from rlbench_pin.sim.render.texture import Texture
from rlbench_pin.sim.render.tone import toned

_EDGE = np.float32(1e9)


class KeptBackdrop:
    """The room as one camera sees it, and what follows from that alone.

    Args:
        view: The camera.
        image: What it sees of the room.
    """

    def __init__(self, view: CameraView, image: Backdrop) -> None:
        self.view, self.image = view, image
        self._spots: tuple[CameraView, TableSpots] | None = None

    @cached_property
    def inverse(self) -> NDArray[np.float32]:
        """Inverse depth [1/m] with one more pixel on every side, ((h + 2) * (w + 2),)."""
        height, width = self.image.depth.shape
        padded = np.full((height + 2, width + 2), _EDGE, dtype=np.float32)
        np.divide(np.float32(1.0), self.image.depth, out=padded[1:-1, 1:-1])
        return padded.ravel()

    @cached_property
    def surfaces(self) -> NDArray[np.uint8]:
        """Which surface each pixel sees, counted down from 255, (h, w); of 256 surfaces apart two look like one."""
        return (255 - self.image.owner).astype(np.uint8)

    def table(self, shadows: ShadowMap) -> TableSpots:
        """Where its pixels that see the table lie in the image that the key light takes."""
        light = shadows.view
        if self._spots is None or self._spots[0] is not light:
            self._spots = light, table_spots(light, self.view, shadows.height, self.image.table)
        return self._spots[1]


def shade_tables(
    images: Sequence[NDArray[np.uint8]],
    backdrops: Sequence[KeptBackdrop],
    shadows: ShadowMap,
    key: NDArray[np.float32],
) -> None:
    """Darken the table in images (h, w, 3) where moving objects stand in the key light.

    Args:
        images: The images, of all cameras.
        backdrops: The room as these cameras see it.
        shadows: The shadows.
        key: Share (3,) of its colour that the key light gives.
    """
    if shadows.is_empty:
        return
    tables = [backdrop.table(shadows) for backdrop in backdrops]
    darker, missing = shadows.at(tables)
    pixels = [spots.pixels.take(chosen) for spots, chosen in zip(tables, darker, strict=True)]
    own = np.concatenate([image.reshape(-1).view(PIXEL).take(each) for image, each in zip(images, pixels, strict=True)])
    shaded = own.view(np.uint8).reshape(-1, 3)
    left: dict[float, NDArray[np.float32]] = {}
    for channel, part in enumerate(key.tolist()):
        if part not in left:
            values = missing * np.float32(-part)
            values += np.float32(1.0)
            left[part] = np.maximum(values, np.float32(0.0), out=values)
        values = left[part] * shaded[:, channel]
        values += np.float32(0.5)
        shaded[:, channel] = values
    ends = np.cumsum([0, *(len(each) for each in pixels)])
    for image, each, a, b in zip(images, pixels, ends, ends[1:]):
        put_pixels(image, each, shaded[a:b])


def put_pixels(image: NDArray[np.uint8], pixels: NDArray[np.int64], colors: NDArray[np.uint8]) -> None:
    """Write colours (n, 3) to some pixels, by flat index, of an image (h, w, 3)."""
    image.reshape(-1).view(PIXEL)[pixels] = np.ascontiguousarray(colors).reshape(-1).view(PIXEL)


def toned_pixels(colors: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Colours (n, 3) of those in 0..255 and above, (3, n), along the tone curve; overwrites them."""
    return np.ascontiguousarray(toned(colors).T)


def put_shot(image: NDArray[np.uint8], shot: Shot, colors: NDArray[np.uint8]) -> None:
    """Write the colours (n, 3) of what a camera sees to its image (h, w, 3): over what is there, which glass lets through."""
    if len(shot.glass):
        under = image.reshape(-1, 3).take(shot.pixels.take(shot.glass), axis=0).astype(np.float32)
        own = colors.take(shot.glass, axis=0)
        under += (own - under) * shot.opacity[:, None]
        colors[shot.glass] = np.rint(under).astype(np.uint8)
    put_pixels(image, shot.pixels, colors)


def put_pools(image: NDArray[np.uint8], backdrop: KeptBackdrop, table: TableSpots, lamps: Sequence[Lamp]) -> None:
    """Brighten the table in an image (h, w, 3) around lamps that shine."""
    view = backdrop.view
    depth = backdrop.image.depth.ravel().take(table.pixels)[:, None]
    points = view.rays.take(table.pixels, axis=0) * depth + view.pose[:3].astype(np.float32)
    for lamp in lamps:
        apart = points - np.array(lamp.position, dtype=np.float32)
        share = _pool((apart * apart).sum(axis=1), lamp)
        chosen = (share > np.float32(0.01)).nonzero()[0]
        pixels = table.pixels.take(chosen)
        colors = image.reshape(-1, 3).take(pixels, axis=0).astype(np.float32)
        light = share.take(chosen)[:, None] * (np.array(lamp.color, dtype=np.float32) * _WARM)
        colors += (np.float32(255.0) - colors) * light
        put_pixels(image, pixels, colors.astype(np.uint8))


def _pool(squared: NDArray[np.float32], lamp: Lamp) -> NDArray[np.float32]:
    """How bright the light of a lamp is at points, by the squares of their distances (n,) [m^2]."""
    return _LAMP * np.exp(squared * np.float32(-1.0 / lamp.reach**2))


def smoothed(images: NDArray[np.uint8], surfaces: NDArray[np.uint8]) -> None:
    """Smooth the edges in images (c, h, w, 3) between pixels that see different surfaces (c, h, w).

    Of a row of pixels along such an edge, one line goes from where it steps to one side to where it steps to the next; each pixel
    takes from the other side what lies there of it. A. Reshetov, Morphological Antialiasing, 2009.
    """
    flat = images.reshape(-1, 3)
    for first, second, share in _crossings_both_ways(surfaces):
        for own, other, sign in ((first, second, 1.0), (second, first, -1.0)):
            chosen = (share * np.float32(sign) > np.float32(0.02)).nonzero()[0]
            weight = np.abs(share.take(chosen))[:, None]
            pixels = own.take(chosen)
            colors = flat.take(pixels, axis=0).astype(np.float32)
            colors += (flat.take(other.take(chosen), axis=0) - colors) * weight
            colors += np.float32(0.5)
            put_pixels(images, pixels, colors.astype(np.uint8))


def _crossings_both_ways(surfaces: NDArray[np.uint8]) -> list[tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float32]]]:
    """Crossings as in `_crossings`, of pixels with those below them and of pixels with those to their right."""
    count, height, width = surfaces.shape
    turned = surfaces.transpose(0, 2, 1)
    if height != width:
        upright, (first, second, share) = _crossings(surfaces), _crossings(np.ascontiguousarray(turned))
    else:
        upper, lower, every = _crossings(np.concatenate([surfaces, turned]))
        end = int(np.searchsorted(upper, surfaces.size))
        upright = upper[:end], lower[:end], every[:end]
        first, second, share = upper[end:] - surfaces.size, lower[end:] - surfaces.size, every[end:]
    return [upright, (_turned_back(first, height, width), _turned_back(second, height, width), share)]


def _turned_back(pixels: NDArray[np.int64], height: int, width: int) -> NDArray[np.int64]:
    """Flat indices (n,) in images (c, h, w) of those in images (c, w, h)."""
    column = pixels // height
    image = column // width
    return image * (height * width) + (pixels - column * height) * width + (column - image * width)


def _crossings(surfaces: NDArray[np.uint8]) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float32]]:
    """Pixels (n,) of images (c, h, w) that see another surface than those below them, these, and how far the edge lies above
    their border as a share of a pixel (n,), negative where it lies below.
    """
    width = surfaces.shape[2]
    flat = surfaces.ravel()
    differs = np.zeros(surfaces.shape, dtype=np.bool_)
    np.not_equal(surfaces[:, :-1], surfaces[:, 1:], out=differs[:, :-1])
    is_same = np.zeros(surfaces.shape, dtype=np.bool_)
    np.equal(surfaces[:, :, 1:], surfaces[:, :, :-1], out=is_same[:, :, 1:])
    # an edge goes on where neither surface is another one than beside it
    goes_on = is_same.ravel()
    goes_on[:-width] &= goes_on[width:]
    goes_on[1:] &= differs.ravel()[:-1]
    upper = differs.ravel().nonzero()[0]
    lower = upper + width
    above, below = flat.take(upper), flat.take(lower)
    begins = np.ones(len(upper) + 1, dtype=np.bool_)
    np.logical_not(goes_on.take(upper), out=begins[:-1])
    ends = begins.nonzero()[0]
    first, length = ends[:-1], np.diff(ends)
    bends = []
    for end, step, border in ((first, -1, 0), (ends[1:] - 1, 1, width - 1)):
        place = upper.take(end)
        inside = place % width != border
        place += inside * step
        up = flat.take(place) == below.take(end)
        down = flat.take(place + width) == above.take(end)
        bend = up.astype(np.float32)
        bend -= down
        bend *= inside * np.float32(0.5)
        bends.append(bend)
    run = np.cumsum(begins[:-1], dtype=np.int64)
    run -= 1
    along = (np.arange(len(upper)) - first.take(run) + np.float32(0.5)) / length.take(run)
    way = (np.float32(1.0) - np.float32(2.0) * along).astype(np.float32)
    left, right = (bend.take(run) for bend in bends)
    left *= np.maximum(way, np.float32(0.0))
    right *= np.minimum(way, np.float32(0.0))
    left -= right
    return upper, lower, left


def halved(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """An image (h, w, 3) of the means of two by two pixels of one of twice the size."""
    sums = image[:, 0::2].astype(np.uint16)
    sums += image[:, 1::2]
    pairs = sums[0::2]
    pairs += sums[1::2]
    pairs += np.uint16(2)
    pairs >>= np.uint16(2)
    return pairs.astype(np.uint8)


_HEIGHTS = np.array([-1.0, -0.25, 0.0, 0.15, 0.55, 0.8, 1.0], dtype=np.float32)
"""z of directions in which glossy objects look."""
_ROOM = np.array([0.30, 0.40, 0.15, 0.50, 0.65, 0.95, 1.05], dtype=np.float32)
"""Brightness of what they mirror there: the table, a dark horizon, walls, lamps at the ceiling."""
_SHARPNESS, _HIGHLIGHT = 6, np.float32(4.0)
"""The cosine to the key light is squared so often, so that its mirror image is 8 degrees wide; how bright its middle is."""
_WINDOWS = np.float32(0.35)
"""How much brighter four of eight directions around are, which draw streaks along round walls."""
_OTHERS = np.array([[1, 2], [0, 2], [0, 1]])
_SKY = np.float32(0.06)
"""By how much more of the ambient light what looks upwards gets, and by how much less what looks downwards."""
_BRIGHT = np.float32(1.25)
"""Light on what shines by itself."""
_LAMP, _WARM = np.float32(0.75), np.array([1.0, 0.86, 0.58], dtype=np.float32)
"""How bright a lamp is, and its colour."""
LinkFrame = Callable[[int, int], NDArray[np.float32]]
"""Returns the placement (4, 4) of a link in the world, by body and link."""


@dataclass(frozen=True, eq=False)
class LinkTexture:
    """A texture on one link."""

    texture: Texture
    repeats: float = 4.0
    """How often the texture repeats along one metre."""


@dataclass(frozen=True, eq=False)
class Surfaces:
    """Moving objects as one camera sees them."""

    backdrop: KeptBackdrop
    """The camera."""
    shot: Shot
    """What it sees."""
    normals: NDArray[np.float32]
    """Unit normals (3, n) in the world."""

    def _rays(self, chosen: NDArray[np.int64] | slice) -> NDArray[np.float32]:
        """Directions of depth 1 in the frame of the camera in which some of them are seen (3, k)."""
        k = self.backdrop.view.intrinsics().astype(np.float32)
        row, column = _places(self.shot.pixels[chosen], self.backdrop.view.size[0])
        rays = np.ones((3, len(row)), dtype=np.float32)
        np.multiply(column - k[0, 2], np.float32(1.0) / k[0, 0], out=rays[0])
        np.multiply(row - k[1, 2], np.float32(1.0) / k[1, 1], out=rays[1])
        return rays

    @cached_property
    def points(self) -> NDArray[np.float32]:
        """Where they are (3, n), in the frame of the camera [m]."""
        return self._rays(slice(None)) * self.shot.depth

    def in_world(self) -> NDArray[np.float32]:
        """Where they are (3, n), in the world [m]."""
        pose = self.backdrop.view.extrinsics().astype(np.float32)
        return pose[:3, :3] @ self.points + pose[:3, 3:]

    def rays(self) -> NDArray[np.float32]:
        """Unit directions (3, k) in the world in which the camera sees what is glossy."""
        rays = self._rays(self.shot.glossy)
        rays /= np.sqrt((rays * rays).sum(axis=0))
        return self.backdrop.view.extrinsics()[:3, :3].astype(np.float32) @ rays

    def spots(self, shadows: ShadowMap, chosen: NDArray[np.int64]) -> LightSpots:
        """Where some of them lie in the image that the key light takes."""
        view = self.backdrop.view
        row, column = _places(self.shot.pixels.take(chosen), view.size[0])
        return spots_of(shadows.view, view, column, row, self.shot.depth.take(chosen))


def surfaces_of(backdrop: KeptBackdrop, shot: Shot) -> Surfaces:
    """Moving objects as one camera sees them; where nothing else tells their normals, they follow from the depth."""
    return Surfaces(backdrop, shot, _normals_of_depth(backdrop, shot) if shot.normals is None else shot.normals)


def colors_in_light(
    surfaces: Sequence[Surfaces], lighting: Lighting, shadows: ShadowMap | None, lamps: Sequence[Lamp]
) -> NDArray[np.float32]:
    """Return the colours (3, n) in 0..255 of what some cameras see, one after the other.

    Args:
        surfaces: What they see; all from the same renderer.
        lighting: The lights.
        shadows: The shadows. Without them fills are part of the ambient light.
        lamps: Lamps that shine; without shadows they light nothing.
    """
    colors = np.concatenate([each.shot.colors for each in surfaces], axis=1)
    normals = np.concatenate([each.normals for each in surfaces], axis=1)
    share = None
    ends = np.cumsum([0, *(len(each.shot.pixels) for each in surfaces)])

    def joined(name: str) -> NDArray[np.int64]:
        return np.concatenate([getattr(each.shot, name) + end for each, end in zip(surfaces, ends)])

    is_lit = any(each.shot.normals is None for each in surfaces)
    if not is_lit or shadows is not None:
        cosine = _on(normals, lighting.key)
        if shadows is not None and not shadows.is_empty:
            # what faces away from the light has none in any case
            facing = cosine.nonzero()[0]
            each = np.split(facing, np.searchsorted(facing, ends[1:-1]))
            spots = [own.spots(shadows, chosen - end) for own, chosen, end in zip(surfaces, each, ends)]
            share = np.zeros_like(cosine)
            share[facing] = shadows.lit(joined_spots(spots), _bias(cosine.take(facing)))
        has_shades = any(each.shot.shades is not None for each in surfaces)
        shades = np.concatenate([_shades(each.shot) for each in surfaces]) if has_shades else None
        light = _light(normals, cosine, share, shades, lighting, shadows is not None)
        if is_lit:
            light /= np.float32(lighting.ambient) + cosine * np.float32(lighting.key.intensity)
        if shadows is not None and lamps:
            light = light + _lamp_light(np.concatenate([each.in_world() for each in surfaces], axis=1), normals, lamps)
        light[..., joined("shining")] = _BRIGHT
        colors *= light
    glossy = joined("glossy")
    if shadows is not None and len(glossy):
        lit = np.float32(1.0) if share is None else share.take(glossy)
        rays = np.concatenate([each.rays() for each in surfaces], axis=1)
        gloss = np.concatenate([each.shot.gloss for each in surfaces], axis=1)
        own = colors.take(glossy, axis=1)
        colors[:, glossy] = _mirrored(own, gloss, rays, normals.take(glossy, axis=1), lit, lighting)
    return colors


def _lamp_light(points: NDArray[np.float32], normals: NDArray[np.float32], lamps: Sequence[Lamp]) -> NDArray[np.float32]:
    """Light (3, n) of lamps on points (3, n) in the world with unit normals (3, n)."""
    total = np.zeros_like(points)
    for lamp in lamps:
        towards = np.array(lamp.position, dtype=np.float32)[:, None] - points
        squared = (towards * towards).sum(axis=0)
        facing = (towards * normals).sum(axis=0) / np.sqrt(np.maximum(squared, np.float32(1e-6)))
        share = _pool(squared, lamp) * np.maximum(np.float32(0.3) + np.float32(0.7) * facing, np.float32(0.0))
        total += (np.array(lamp.color, dtype=np.float32) * _WARM)[:, None] * share
    return total


def _mirrored(
    colors: NDArray[np.float32],
    gloss: NDArray[np.float32],
    rays: NDArray[np.float32],
    normals: NDArray[np.float32],
    lit: NDArray[np.float32] | np.float32,
    lighting: Lighting,
) -> NDArray[np.float32]:
    """Colours (3, k) in 0..255 of glossy points, with what they mirror: more of it at a grazing angle; overwrites `colors`.

    C. Schlick, An Inexpensive BRDF Model for Physically-based Rendering, 1994, equation 15.

    Args:
        colors: Their own colours (3, k) in the light.
        gloss: Share of red, green, blue that they mirror (3, k).
        rays: Unit directions (3, k) in the world in which they are seen.
        normals: Their unit normals (3, k) in the world.
        lit: Share of the key light that reaches them (k,).
        lighting: The lights.
    """
    cosine = np.minimum((rays * normals).sum(axis=0), np.float32(0.0))
    seen = rays - (np.float32(2.0) * cosine) * normals
    strongest = gloss.max(axis=0)
    grazing = np.float32(1.0) + cosine
    grazing *= (grazing * grazing) ** 2
    share = gloss + (strongest - gloss * strongest) * grazing
    light = _on(seen, lighting.key)
    for _ in range(_SHARPNESS):
        light *= light
    light *= lit * (_HIGHLIGHT * np.float32(lighting.key.intensity))
    x, y = seen[0] * seen[0], seen[1] * seen[1]
    light += _WINDOWS * (x * x - np.float32(6.0) * x * y + y * y)
    light += np.interp(seen[2], _HEIGHTS, _ROOM).astype(np.float32)
    light *= np.float32(255.0)
    colors *= np.float32(1.0) - share.max(axis=0)
    colors += share * light
    return colors


def _light(
    normals: NDArray[np.float32],
    cosine: NDArray[np.float32],
    share: NDArray[np.float32] | None,
    shades: NDArray[np.float32] | None,
    lighting: Lighting,
    has_fills: bool,
) -> NDArray[np.float32]:
    """Brightness (n,), or (3, n) where lights are coloured, with a highlight where what mirrors the light looks upwards.

    Args:
        normals: Unit normals (3, n) in the world.
        cosine: Of the angle to the key light (n,), 0 where they point away.
        share: Share of the key light that reaches the points (n,); all of it when None.
        shades: Share of all other light that reaches them (n,); all of it when None.
        lighting: The lights.
        has_fills: Whether fills shine; otherwise they are part of the ambient light, and all lights are white.
    """
    key_light = lighting.key
    mirrored = (np.float32(2.0) * cosine) * normals[2]
    mirrored -= np.float32(key_light.unit[2])
    np.maximum(mirrored, np.float32(0.0), out=mirrored)
    mirrored *= mirrored
    mirrored *= np.float32(SPECULAR if key_light.intensity else 0.0)
    key = cosine * np.float32(key_light.intensity)
    key += mirrored
    if share is not None:
        key *= share
    if not has_fills:
        return key + np.float32(lighting.ambient + lighting.mean_fill) * (np.float32(1.0) if shades is None else shades)
    ambient = normals[2] * _SKY
    ambient += np.float32(lighting.ambient)
    if lighting.is_white:
        for fill in lighting.fills:
            ambient += _on(normals, fill) * np.float32(fill.intensity)
        if shades is not None:
            ambient *= shades
        key += ambient
        return key
    tint = np.array(key_light.color, dtype=np.float32)
    mixed = ambient * (tint * np.float32(0.5) + np.float32(0.5))[:, None]
    for fill in lighting.fills:
        mixed += _on(normals, fill) * np.array(fill.color, dtype=np.float32)[:, None] * np.float32(fill.intensity)
    if shades is not None:
        mixed *= shades
    mixed += key * tint[:, None]
    return mixed


def _shades(shot: Shot) -> NDArray[np.float32]:
    return np.ones(len(shot.pixels), dtype=np.float32) if shot.shades is None else shot.shades


def _on(normals: NDArray[np.float32], light: Light) -> NDArray[np.float32]:
    """Cosines (n,) between normals (3, n) and the direction to a light, 0 where they point away from each other."""
    x, y, z = light.unit.astype(np.float32)
    cosine = normals[0] * x
    cosine += normals[1] * y
    cosine += normals[2] * z
    return np.maximum(cosine, np.float32(0.0), out=cosine)


def _bias(cosine: NDArray[np.float32]) -> NDArray[np.float32]:
    """By how much (n,) an object must be nearer to the light to shade a point; surfaces that light grazes have more room [m]."""
    tangent = np.sqrt(np.float32(1.0) - np.minimum(cosine, np.float32(1.0)) ** 2) / np.maximum(cosine, np.float32(0.15))
    tangent *= np.float32(0.008)
    tangent += np.float32(0.006)
    return tangent


def put_textures(
    colors: NDArray[np.float32], surfaces: Surfaces, textures: Mapping[tuple[int, int], LinkTexture], frame: LinkFrame
) -> None:
    """Multiply colours (3, n) by textures of links.

    Args:
        colors: Colours of the points.
        surfaces: The points.
        textures: Textures by body and link.
        frame: Says where a link is.
    """
    shot, focal = surfaces.shot, np.float32(-surfaces.backdrop.view.intrinsics()[0, 0])
    pose, local = surfaces.backdrop.view.extrinsics().astype(np.float32), surfaces.points
    segments = shot.segments.take(shot.segment)
    for (body, link), texture in textures.items():
        chosen = np.flatnonzero(segments == segment_of(body, link))
        if len(chosen):
            points = local[:, chosen].T @ pose[:3, :3].T + pose[:3, 3]
            normals = np.ascontiguousarray(surfaces.normals[:, chosen].T)
            colors[:, chosen] *= _texture_colors(texture, frame(body, link), points, normals, shot.depth[chosen] / focal).T


def _texture_colors(
    link_texture: LinkTexture,
    frame: NDArray[np.float32],
    points: NDArray[np.float32],
    normals: NDArray[np.float32],
    metres_per_pixel: NDArray[np.float32],
) -> NDArray[np.float32]:
    """Colours (n, 3) in 0..1 of points on a link.

    Args:
        link_texture: The texture on it.
        frame: Placement (4, 4) of the link in the world.
        points: World points (n, 3) [m].
        normals: Unit normals (n, 3) in the world.
        metres_per_pixel: Size of a pixel at each point (n,) [m].
    """
    rotation = frame[:3, :3]
    local, axis = (points - frame[:3, 3]) @ rotation, np.argmax(np.abs(normals @ rotation), axis=1)
    plane = np.take_along_axis(local, _OTHERS[axis], axis=1) * np.float32(link_texture.repeats)
    texture = link_texture.texture
    density = np.float32(texture.size * link_texture.repeats)
    return texture.texels[texture.indices(plane[:, 0], plane[:, 1], metres_per_pixel * density)]


def _places(pixels: NDArray[np.int64], width: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Rows and columns (n,) of pixels."""
    row = pixels // width
    return row.astype(np.float32), (pixels - row * width).astype(np.float32)


def _normals_of_depth(backdrop: KeptBackdrop, shot: Shot) -> NDArray[np.float32]:
    """Unit normals (3, n) in the world of what a camera sees, from its depth.

    On a plane m . P = 1 the inverse depth is m . ray, affine over the image; its slopes therefore give m. At edges the smaller
    of the two one-sided slopes is that of the surface itself.
    """
    view = backdrop.view
    width = view.size[0]
    row, column = _places(shot.pixels, width)
    place = shot.pixels + 2 * (shot.pixels // width)
    place += width + 3
    inverse = backdrop.inverse.copy()
    inverse[place] = here = shot.inverse
    along = _smaller(inverse.take(place + 1) - here, here - inverse.take(place - 1))
    down = _smaller(inverse.take(place + (width + 2)) - here, here - inverse.take(place - (width + 2)))
    k = view.intrinsics().astype(np.float32)
    normals = np.stack([along * -k[0, 0], down * -k[1, 1], along * (column - k[0, 2]) + down * (row - k[1, 2]) - here])
    normals /= np.maximum(np.sqrt((normals * normals).sum(axis=0)), np.float32(1e-12))
    return view.extrinsics()[:3, :3].astype(np.float32) @ normals


def _smaller(a: NDArray[np.float32], b: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.where(np.abs(a) < np.abs(b), a, b)
