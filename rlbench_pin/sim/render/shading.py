"""Light, shadows and textures on the room and on moving objects.

Textures on moving objects are projected along the main axes of each link; texture coordinates of meshes are ignored.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

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
    table_spots,
    to_light,
)
from rlbench_pin.sim.render.masks import bodies_of, rows_of, segment_of
from rlbench_pin.sim.render.raster.stage import Lamp
from rlbench_pin.sim.render.shots import Shot
from rlbench_pin.sim.render.texture import Texture
from rlbench_pin.sim.render.tone import toned

_EDGE = np.float32(1e9)


class KeptBackdrop:
    """Image of the room from one camera, and values derived from it.

    Args:
        view: The camera.
        image: Its image of the room.
        bare: Colours (h, w, 3) without shadows if those of the image have some.

    Attributes:
        view: The same.
        image: The same.
        bare: Colours without shadows.
        is_shaded: Whether those of the image have shadows.
        table_spots: A key light, and the positions of the pixels of the table in its image; None until the first request.
    """

    def __init__(self, view: CameraView, image: Backdrop, bare: NDArray[np.uint8] | None = None) -> None:
        self.view, self.image = view, image
        self.is_shaded = bare is not None
        self.bare = image.rgb if bare is None else bare
        self.table_spots: tuple[CameraView, TableSpots] | None = None

    def with_stationary(self, sheet: Sheet, number: int, covered: NDArray[np.bool_], shadows: ShadowMap) -> KeptBackdrop:
        """Return the room with stationary links in front of it.

        Args:
            sheet: Images of both.
            number: Number of this camera in them.
            covered: Which of all pixels see the links (n,).
            shadows: The shadows of the links.
        """
        rgb, depth, mask, surfaces = (
            sheet.part(values, number).copy() for values in (sheet.bytes, sheet.depth, sheet.ids, sheet.surfaces)
        )
        result = KeptBackdrop(self.view, replace(self.image, rgb=rgb, depth=depth, mask=mask), self.image.rgb)
        result.surfaces = surfaces
        table = self.table(shadows)
        free = (~sheet.part(covered, number).ravel().take(table.pixels)).nonzero()[0]
        names = ("pixels", "right", "down", "block")
        result.table_spots = shadows.view, replace(table, **{name: getattr(table, name).take(free) for name in names})
        return result

    @cached_property
    def inverse(self) -> NDArray[np.float32]:
        """Inverse depth [1/m] with one more pixel on every side, ((h + 2) * (w + 2),)."""
        height, width = self.image.depth.shape
        padded = np.full((height + 2, width + 2), _EDGE, dtype=np.float32)
        np.divide(np.float32(1.0), self.image.depth, out=padded[1:-1, 1:-1])
        return padded.ravel()

    @cached_property
    def surfaces(self) -> NDArray[np.uint8]:
        """Surface in each pixel, counted down from 255, (h, w); surfaces whose numbers differ by 256 are not distinguished."""
        return (255 - self.image.owner).astype(np.uint8)

    def table(self, shadows: ShadowMap) -> TableSpots:
        """Positions of its pixels of the table in the image of the key light."""
        light = shadows.view
        if self.table_spots is None or self.table_spots[0] is not light:
            self.table_spots = light, table_spots(light, self.view, shadows.height, self.image.table)
        return self.table_spots[1]


class Sheet:
    """The images of some cameras in one row of pixels, of the room at first.

    Args:
        backdrops: The room as these cameras see it.
        has_colors: Whether there are colours.
        has_ids: Whether there are ids.

    Attributes:
        backdrops: The same.
        depth: Depth (n,) [m].
        colors: Colours (n,) of type `PIXEL`; empty without colours.
        surfaces: Surface in each pixel (n,); empty without colours.
        ids: Mask ids (n,); empty without ids.
    """

    def __init__(self, backdrops: Sequence[KeptBackdrop], has_colors: bool, has_ids: bool) -> None:
        self.backdrops, self._has_ids = backdrops, has_ids
        images = [backdrop.image for backdrop in backdrops]
        self.starts = np.cumsum([0, *(image.depth.size for image in images)])
        self.depth = np.concatenate([image.depth.ravel() for image in images])
        self.colors, self.surfaces, self.ids = np.zeros(0, PIXEL), np.zeros(0, np.uint8), np.zeros(0, np.int32)
        if has_colors:
            self.colors = np.concatenate([image.rgb.reshape(-1).view(PIXEL) for image in images])
            self.surfaces = np.concatenate([backdrop.surfaces.ravel() for backdrop in backdrops])
        if has_ids:
            self.ids = np.concatenate([image.mask.ravel() for image in images])

    @property
    def bytes(self) -> NDArray[np.uint8]:
        """Its colours (n, 3)."""
        return self.colors.view(np.uint8).reshape(-1, 3)

    def part(self, values: NDArray, number: int) -> NDArray:
        """Return the image (h, w, ...) of one camera from values of all pixels (n, ...)."""
        part: NDArray = values[self.starts[number] : self.starts[number + 1]]
        return part.reshape(*self.backdrops[number].image.depth.shape, *part.shape[1:])

    def put(self, pixels: NDArray[np.int64], colors: NDArray[np.uint8]) -> None:
        """Write colours (k, 3) to some pixels."""
        self.colors[pixels] = np.ascontiguousarray(colors).reshape(-1).view(PIXEL)

    def shade_tables(self, shadows: ShadowMap, key: NDArray[np.float32], near: NDArray[np.bool_] | None = None) -> None:
        """Darken the table in the shadows of moving objects.

        Args:
            shadows: The shadows.
            key: Share (3,) of its colour that the key light gives.
            near: Blocks of texels (n, n) in which shadows have changed, for images that are shaded.
        """
        if shadows.is_empty:
            return
        again = [near.ravel() if near is not None and backdrop.is_shaded else None for backdrop in self.backdrops]
        each, missing = shadows.at([backdrop.table(shadows) for backdrop in self.backdrops], again)
        bare = [backdrop.bare.reshape(-1).view(PIXEL).take(own) for backdrop, own in zip(self.backdrops, each, strict=True)]
        shaded = np.concatenate(bare).view(np.uint8).reshape(-1, 3)
        pixels = np.concatenate(each)
        pixels += np.repeat(self.starts[:-1], [len(own) for own in each])
        left: dict[float, NDArray[np.float32]] = {}
        for channel, part in enumerate(key.tolist()):
            if part not in left:
                values = missing * np.float32(-part)
                values += np.float32(1.0)
                left[part] = np.maximum(values, np.float32(0.0), out=values)
            values = left[part] * shaded[:, channel]
            values += np.float32(0.5)
            shaded[:, channel] = values
        self.put(pixels, shaded)

    def put_pools(self, shadows: ShadowMap, lamps: Sequence[Lamp]) -> None:
        """Brighten the table around lamps that are on."""
        for start, backdrop in zip(self.starts, self.backdrops):
            view, table = backdrop.view, backdrop.table(shadows).pixels
            depth = backdrop.image.depth.ravel().take(table)[:, None]
            points = view.rays.take(table, axis=0) * depth + view.pose[:3].astype(np.float32)
            for lamp in lamps:
                apart = points - np.array(lamp.position, dtype=np.float32)
                share = _pool((apart * apart).sum(axis=1), lamp)
                chosen = (share > np.float32(0.01)).nonzero()[0]
                pixels = table.take(chosen) + start
                colors = self.bytes.take(pixels, axis=0).astype(np.float32)
                light = share.take(chosen)[:, None] * (np.array(lamp.color, dtype=np.float32) * _WARM)
                colors += (np.float32(255.0) - colors) * light
                self.put(pixels, colors.astype(np.uint8))

    def put_colors(self, shot: Shot, colors: NDArray[np.uint8]) -> None:
        """Write the colours (n, 3) of the visible objects; those of glass over others."""
        pixels, solid = shot.pixels, len(shot.pixels) - len(shot.opacity)
        self.put(pixels[:solid], colors[:solid])
        if len(shot.opacity):
            under = self.bytes.take(pixels[solid:], axis=0).astype(np.float32)
            under += (colors[solid:] - under) * shot.opacity[:, None]
            self.put(pixels[solid:], np.rint(under).astype(np.uint8))

    def put_depth_and_ids(self, shot: Shot, ids: NDArray[np.int32]) -> None:
        """Write depth and ids of the visible objects; `ids` has the mask id of body b and link l at `[b, l + 1]`."""
        self.depth[shot.pixels] = shot.depth
        if len(self.surfaces):
            self.surfaces[shot.pixels] = shot.surface
        if self._has_ids:
            of_segments = ids[bodies_of(shot.segments), rows_of(shot.segments)]
            self.ids[shot.pixels] = of_segments.take(shot.segment)

    def smooth(self, chosen: Sequence[int]) -> None:
        """Smooth the edges in some images."""
        shapes = {backdrop.image.depth.shape for backdrop in self.backdrops}
        if len(shapes) == 1 and len(chosen) == len(self.backdrops):
            height, width = shapes.pop()
            smoothed(self.bytes.reshape(-1, height, width, 3), self.surfaces.reshape(-1, height, width))
        else:
            for number in chosen:
                smoothed(self.part(self.bytes, number)[None], self.part(self.surfaces, number)[None])


def _pool(squared: NDArray[np.float32], lamp: Lamp) -> NDArray[np.float32]:
    """How bright the light of a lamp is at points, by the squares of their distances (n,) [m^2]."""
    return _LAMP * np.exp(squared * np.float32(-1.0 / lamp.reach**2))


def smoothed(images: NDArray[np.uint8], surfaces: NDArray[np.uint8]) -> None:
    """Smooth the edges in images (c, h, w, 3) between pixels that see different surfaces (c, h, w).

    Along a row of pixels at such an edge, a line connects the two steps of the edge. Each pixel is blended with the other side by
    its share beyond the line. A. Reshetov, Morphological Antialiasing, 2009.
    """
    flat, own_pixels = images.reshape(-1, 3), images.reshape(-1).view(PIXEL)
    for first, step, share in _crossings_both_ways(surfaces):
        second = first + step
        for own, other, sign in ((first, second, 1.0), (second, first, -1.0)):
            chosen = (share * np.float32(sign) > np.float32(0.02)).nonzero()[0]
            weight = np.abs(share.take(chosen))[:, None]
            pixels = own.take(chosen)
            colors = flat.take(pixels, axis=0).astype(np.float32)
            colors += (flat.take(other.take(chosen), axis=0) - colors) * weight
            colors += np.float32(0.5)
            own_pixels[pixels] = colors.astype(np.uint8).reshape(-1).view(PIXEL)


def _crossings_both_ways(surfaces: NDArray[np.uint8]) -> list[tuple[NDArray[np.int64], int, NDArray[np.float32]]]:
    """Crossings as in `_crossings` of pixels with those below them and of pixels with those to their right: pixels (n,), steps to
    the others, and shares (n,).
    """
    _, height, width = surfaces.shape
    turned = surfaces.transpose(0, 2, 1)
    if height != width:
        (upper, share), (beside, across) = _crossings(surfaces), _crossings(np.ascontiguousarray(turned))
    else:
        every, shares = _crossings(np.concatenate([surfaces, turned]))
        end = int(np.searchsorted(every, surfaces.size))
        upper, share, beside, across = every[:end], shares[:end], every[end:] - surfaces.size, shares[end:]
    return [(upper, width, share), (_turned_back(surfaces.shape).take(beside), 1, across)]


@lru_cache(maxsize=8)
def _turned_back(shape: tuple[int, ...]) -> NDArray[np.int64]:
    """Flat indices (n,) in images (c, h, w) of all pixels of images (c, w, h)."""
    return np.arange(np.prod(shape)).reshape(shape).transpose(0, 2, 1).ravel()


def _crossings(surfaces: NDArray[np.uint8]) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Pixels (n,) of images (c, h, w) whose surface differs from that below them, and the distance of the edge above their
    border as a share of a pixel (n,), negative below it.
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
    above, below = flat.take(upper), flat.take(upper + width)
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
    return upper, left


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
_RIM, _MIDDLE = np.float32(1.0), np.float32(0.5)
"""Light of what shines by itself where it is seen along its surface, and how much more of it where it faces the camera."""
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


def _rays(shot: Shot, chosen: NDArray[np.int64]) -> NDArray[np.float32]:
    """Unit directions (3, k) in the world from the camera to some pixels."""
    rays = np.ones((3, len(chosen)), dtype=np.float32)
    rays[0], rays[1] = shot.column.take(chosen), shot.row.take(chosen)
    for _, view, part in shot.parts(chosen):
        k = view.intrinsics().astype(np.float32)
        for axis in (0, 1):
            rays[axis, part] -= k[axis, 2]
            rays[axis, part] *= np.float32(1.0) / k[axis, axis]
    rays /= np.sqrt((rays * rays).sum(axis=0))
    for _, view, part in shot.parts(chosen):
        rays[:, part] = view.extrinsics()[:3, :3].astype(np.float32) @ rays[:, part]
    return rays


def _facing(shot: Shot, normals: NDArray[np.float32], chosen: NDArray[np.int64]) -> NDArray[np.float32]:
    """Cosine (k,) between the normals of some pixels and the direction in which their camera looks; a plane has one value."""
    own, facing = normals.take(chosen, axis=1), np.empty(len(chosen), dtype=np.float32)
    for _, view, part in shot.parts(chosen):
        facing[part] = view.extrinsics()[:3, 2].astype(np.float32) @ own[:, part]
    return facing


def _points(view: CameraView, shot: Shot, part: slice) -> NDArray[np.float32]:
    """Where the pixels of one camera are (3, k), in its frame [m]."""
    k = view.intrinsics().astype(np.float32)
    x, y = shot.column[part] - k[0, 2], shot.row[part] - k[1, 2]
    return np.stack([x * (np.float32(1.0) / k[0, 0]), y * (np.float32(1.0) / k[1, 1]), np.ones_like(x)]) * shot.depth[part]


def _in_world(shot: Shot) -> NDArray[np.float32]:
    """Where the pixels are (3, n), in the world [m]."""
    points = np.empty((3, len(shot.pixels)), dtype=np.float32)
    for _, view, part in shot.parts():
        pose = view.extrinsics().astype(np.float32)
        points[:, part] = pose[:3, :3] @ _points(view, shot, part) + pose[:3, 3:]
    return points


def _spots(shot: Shot, light: CameraView, chosen: NDArray[np.int64]) -> LightSpots:
    """Positions of some pixels in the image of the key light."""
    depth = shot.depth.take(chosen)
    points, found = np.empty((4, len(chosen)), dtype=np.float32), np.empty((3, len(chosen)), dtype=np.float32)
    np.multiply(shot.column.take(chosen), depth, out=points[0])
    np.multiply(shot.row.take(chosen), depth, out=points[1])
    points[2], points[3] = depth, 1.0
    for _, view, part in shot.parts(chosen):
        np.matmul(to_light(light, view), points[:, part], out=found[:, part])
    right, down, along = found
    for values in (right, down):
        values /= along
        values += np.float32(0.5)
    return LightSpots(right, down, along)


def light_blocks(shot: Shot, light: CameraView) -> NDArray[np.int64]:
    """Return the blocks of four by four pixels of the image of a light that contain visible points of cameras (n,)."""
    spots = _spots(shot, light, np.arange(len(shot.pixels)))
    width, height = light.size
    column, row = (
        np.clip(values, 0.0, side - 1.0).astype(np.int64) >> 2 for values, side in ((spots.right, width), (spots.down, height))
    )
    return row * (width // 4) + column


def bytes_of(colors: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Return colours (n, 3) after the tone curve, of colours (3, n) in 0..255 and above, which are overwritten."""
    return np.ascontiguousarray(toned(colors).T)


def colors_in_light(
    shot: Shot, normals: NDArray[np.float32], lighting: Lighting, shadows: ShadowMap | None, lamps: Sequence[Lamp]
) -> NDArray[np.float32]:
    """Return the colours (3, n) in 0..255 of the objects in some cameras.

    Args:
        shot: The visible objects.
        normals: Unit normals (3, n) in the world.
        lighting: The lights.
        shadows: The shadows. Without them fills are part of the ambient light.
        lamps: Lamps that are on; without shadows they have no effect.
    """
    colors, share, is_lit = shot.colors, None, shot.normals is None
    if not is_lit or shadows is not None:
        cosine = _on(normals, lighting.key)
        if shadows is not None and not shadows.is_empty:
            # what faces away from the light has none in any case
            facing = cosine.nonzero()[0]
            share = np.zeros_like(cosine)
            share[facing] = shadows.lit(_spots(shot, shadows.view, facing), _bias(cosine.take(facing)))
        light = _light(normals, cosine, share, shot.shades, lighting, shadows is not None)
        if is_lit:
            light /= np.float32(lighting.ambient) + cosine * np.float32(lighting.key.intensity)
        if shadows is not None and lamps:
            light = light + _lamp_light(_in_world(shot), normals, lamps)
        if len(shot.shining):
            to_camera = _facing(shot, normals, shot.shining)
            light[..., shot.shining] = _RIM + _MIDDLE * to_camera * to_camera
        colors *= light
    glossy = shot.glossy
    if shadows is not None and len(glossy):
        lit = np.float32(1.0) if share is None else share.take(glossy)
        own = colors.take(glossy, axis=1)
        colors[:, glossy] = _mirrored(own, shot.gloss, _rays(shot, glossy), normals.take(glossy, axis=1), lit, lighting)
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
    """Return colours (3, k) in 0..255 of glossy points with reflections, stronger at grazing angles; overwrite `colors`.

    C. Schlick, An Inexpensive BRDF Model for Physically-based Rendering, 1994, equation 15.

    Args:
        colors: Their own colours (3, k) in the light.
        gloss: Share of red, green, blue that they reflect (3, k).
        rays: Unit directions (3, k) in the world from the camera to them.
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
    """Brightness (n,), or (3, n) where lights are coloured, with a highlight where the reflecting surface faces upwards.

    Args:
        normals: Unit normals (3, n) in the world.
        cosine: Of the angle to the key light (n,), 0 where they point away.
        share: Share of the key light that reaches the points (n,); all of it when None.
        shades: Share of all other light that reaches them (n,); all of it when None.
        lighting: The lights.
        has_fills: Whether fill lights are on; otherwise they are part of the ambient light, and all lights are white.
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


def _on(normals: NDArray[np.float32], light: Light) -> NDArray[np.float32]:
    """Cosines (n,) between normals (3, n) and the direction to a light, 0 where they point away from each other."""
    x, y, z = light.unit.astype(np.float32)
    cosine = normals[0] * x
    cosine += normals[1] * y
    cosine += normals[2] * z
    return np.maximum(cosine, np.float32(0.0), out=cosine)


def _bias(cosine: NDArray[np.float32]) -> NDArray[np.float32]:
    """Depth bias (n,) of points for shadows [m]; it is larger at grazing light."""
    tangent = np.sqrt(np.float32(1.0) - np.minimum(cosine, np.float32(1.0)) ** 2) / np.maximum(cosine, np.float32(0.15))
    tangent *= np.float32(0.008)
    tangent += np.float32(0.006)
    return tangent


def put_textures(
    colors: NDArray[np.float32],
    shot: Shot,
    normals: NDArray[np.float32],
    textures: Mapping[tuple[int, int], LinkTexture],
    frame: LinkFrame,
) -> None:
    """Multiply colours (3, n) by textures of links.

    Args:
        colors: Colours of the points.
        shot: The points.
        normals: Unit normals (3, n) in the world.
        textures: Textures by body and link.
        frame: Says where a link is.
    """
    for _, view, part in shot.parts():
        pose, local = view.extrinsics().astype(np.float32), _points(view, shot, part)
        segments = shot.segments.take(shot.segment[part])
        widths = shot.depth[part] / np.float32(-view.intrinsics()[0, 0])
        for (body, link), texture in textures.items():
            chosen = np.flatnonzero(segments == segment_of(body, link))
            if len(chosen):
                points = local[:, chosen].T @ pose[:3, :3].T + pose[:3, 3]
                own = np.ascontiguousarray(normals[:, part.start + chosen].T)
                colors[:, part.start + chosen] *= _texture_colors(texture, frame(body, link), points, own, widths[chosen]).T


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


def normals_of_depth(backdrops: Sequence[KeptBackdrop], shot: Shot) -> NDArray[np.float32]:
    """Return unit normals (3, n) in the world of the visible surfaces of some cameras, from their depth.

    On a plane m . P = 1 the inverse depth is m . ray, affine over the image; its slopes therefore give m. At edges the smaller
    of the two one-sided slopes is that of the surface itself.
    """
    result = np.empty((3, len(shot.pixels)), dtype=np.float32)
    for number, view, part in shot.parts():
        width = view.size[0]
        row, column, here = shot.row[part], shot.column[part], shot.inverse[part]
        place = (row.astype(np.int64) + 1) * (width + 2) + column.astype(np.int64) + 1
        inverse = backdrops[number].inverse.copy()
        inverse[place] = here
        along = _smaller(inverse.take(place + 1) - here, here - inverse.take(place - 1))
        down = _smaller(inverse.take(place + (width + 2)) - here, here - inverse.take(place - (width + 2)))
        k = view.intrinsics().astype(np.float32)
        normals = np.stack([along * -k[0, 0], down * -k[1, 1], along * (column - k[0, 2]) + down * (row - k[1, 2]) - here])
        normals /= np.maximum(np.sqrt((normals * normals).sum(axis=0)), np.float32(1e-12))
        result[:, part] = view.extrinsics()[:3, :3].astype(np.float32) @ normals
    return result


def _smaller(a: NDArray[np.float32], b: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.where(np.abs(a) < np.abs(b), a, b)
