"""Images of moving objects: drawn by numpy for all cameras at once, or by PyBullet's renderers one by one."""

from __future__ import annotations

from array import array
from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.client import PhysicsClient, bullet
from rlbench_pin.sim.output import captured_output
from rlbench_pin.sim.render.camera import CameraView, projection_matrix
from rlbench_pin.sim.render.lighting import SPECULAR, Lighting
from rlbench_pin.sim.render.masks import bodies_of
from rlbench_pin.sim.render.raster.drawing import TOUCHING, Blocked, CameraGroup, Drawing, Drawn
from rlbench_pin.sim.render.raster.stage import Appearance, Lamp, Materials, Parts, Placed, Stage

_HARDWARE_NEAR = 0.03  # its depth has so few bits that a nearer plane would cost millimetres [m]


_NONE: NDArray[np.int64] = np.zeros(0, dtype=np.int64)
_DULL: NDArray[np.float32] = np.zeros((3, 0), dtype=np.float32)


@dataclass(frozen=True, eq=False)
class Shot:
    """The pixels of some images that show moving objects, image by image; then those of glass in front of the others."""

    views: Sequence[CameraView]
    """Camera of each image (c,)."""
    ends: NDArray[np.int64]
    """Which pixels are the first of each image (c + 1,), or (2 c + 1,) where glass is seen."""
    pixels: NDArray[np.int64]
    """Flat indices (n,), image after image; those of an image ascend."""
    row: NDArray[np.float32]
    """Rows of the pixels in their images (n,)."""
    column: NDArray[np.float32]
    """Their columns (n,)."""
    inverse: NDArray[np.float32]
    """Inverse depth (n,) [1/m]."""
    depth: NDArray[np.float32]
    """(n,) [m]."""
    segments: NDArray[np.int32]
    """Some segmentation values (s,)."""
    segment: NDArray[np.int64]
    """Which of them each pixel has (n,)."""
    colors: NDArray[np.float32]
    """Colours (3, n) in 0..255; none when no colours were wanted."""
    normals: NDArray[np.float32] | None
    """Unit normals (3, n) in the world. None when the renderer does not tell; then the colours are those in the ambient and key
    light without shadows, otherwise those of the objects themselves."""
    surface: NDArray[np.int64]
    """Number of the visual that each pixel sees, or of its link where the renderer does not say (n,)."""
    glossy: NDArray[np.int64] = field(default_factory=lambda: _NONE)
    """Which of the pixels see something glossy (k,)."""
    gloss: NDArray[np.float32] = field(default_factory=lambda: _DULL)
    """Share of red, green, blue that it throws back like a mirror (3, k)."""
    shining: NDArray[np.int64] = field(default_factory=lambda: _NONE)
    """Which of the pixels see something that shines (s,)."""
    opacity: NDArray[np.float32] = field(default_factory=lambda: _DULL[0])
    """How much of what is behind it the glass hides (g,), 0..1, for the last g pixels."""
    shades: NDArray[np.float32] | None = None
    """How much of the ambient light reaches the points (n,), 0..1; all of it when None."""

    def parts(self, chosen: NDArray[np.int64] | None = None) -> Iterator[tuple[int, CameraView, slice]]:
        """Yield each image with such pixels, by number, with its camera and its part of the pixels, or of those `chosen`."""
        ends = (self.ends if chosen is None else np.searchsorted(chosen, self.ends)).tolist()
        for n, (begin, end) in enumerate(zip(ends, ends[1:])):
            if end > begin:
                yield n % len(self.views), self.views[n % len(self.views)], slice(begin, end)


class Shooting(Protocol):
    """Moving objects in the cameras of one instant.

    Attributes:
        lamps: Lamps that shine.
    """

    lamps: Sequence[Lamp]

    def shot(self, number: int, limit: NDArray[np.float32] | None) -> Shot:
        """Return what a group of cameras sees.

        Args:
            number: Number of the group.
            limit: Depth of all their pixels (n,), image after image, from which on nothing is seen [m]; nothing hides anything
                when None.
        """

    def blocked(self) -> Blocked:
        """Return what stands in the light that looks."""


class NumpyShooting:
    """Drawn by numpy.

    Args:
        stage: The objects.
        placed: Their triangles.
        camera_groups: The groups of cameras.
        light: Camera of a light, if one looks.

    Attributes:
        lamps: Lamps that shine.
        state: What is equal as long as the same links are stationary before the same cameras and look the same, or None.
    """

    def __init__(self, stage: Stage, placed: Placed, camera_groups: Sequence[CameraGroup], light: CameraView | None) -> None:
        self._parts, self._materials, self._camera_groups = placed.parts, stage.materials, camera_groups
        self._firsts = np.cumsum([0, *(len(camera_group.views) for camera_group in camera_groups)]).tolist()
        opacity = stage.materials.opacity.take(placed.parts.shape)
        views = [view for camera_group in camera_groups for view in camera_group.views]
        self._drawing = Drawing(placed, stage.layers, opacity, views, light)
        self.lamps: Sequence[Lamp] = stage.lamps()
        states = self._drawing.states()
        self.state = (stage.materials, *states) if light is not None and states[-1] is not None else None

    def shot(self, number: int, limit: NDArray[np.float32] | None, again: NDArray[np.int64] | None = None) -> Shot:
        """Return what a group of cameras sees; with `again` stationary cameras see stationary links in these pixels alone."""
        return self._shot(self._drawing.seen(self._camera_groups[number], self._firsts[number], limit, again), number)

    def blocked(self) -> Blocked:
        """Return what stands in the light."""
        return self._drawing.all_blocked()

    def stationary(self, number: int, limit: NDArray[np.float32]) -> tuple[Shot, Blocked, list[bool]]:
        """Return what stationary cameras of a group and the light see of stationary links, and which cameras are stationary."""
        camera_group, first = self._camera_groups[number], self._firsts[number]
        is_kept = [state is not None for state in self._drawing.states()[first : first + len(camera_group.views)]]
        return (
            self._shot(self._drawing.stationary(camera_group, first, limit), number),
            self._drawing.all_blocked(stationary=True),
            is_kept,
        )

    def moving(self) -> tuple[Blocked, NDArray[np.bool_]]:
        """Return what stands in the light where more than stationary links is, and of blocks of four by four pixels, (n, n),
        whether it is there.
        """
        return self._drawing.blocked(), self._drawing.changed()

    def _shot(self, drawn: Drawn, number: int) -> Shot:
        return _shot(drawn, self._parts, self._materials, self._camera_groups[number])


class NumpyRasterizer:
    """Rasterizer with numpy; TinyRenderer draws scenes with shapes that numpy cannot draw.

    Args:
        client: The physics server.
        room: Numbers of the bodies of the room.
        appearance: Appearance that the server does not report.
    """

    def __init__(self, client: PhysicsClient, room: frozenset[int], appearance: Appearance) -> None:
        self._stage, self._other = Stage(client, room, appearance), BulletRasterizer(client, room)

    def shoot(self, camera_groups: Sequence[CameraGroup], lighting: Lighting, light: CameraView | None) -> Shooting:
        """Look through some cameras, and through `light`, the camera of a light."""
        placed = self._stage.update()
        if placed is None:
            return self._other.shoot(camera_groups, lighting, light)
        return NumpyShooting(self._stage, placed, camera_groups, light)


def _shot(drawn: Drawn, parts: Parts, materials: Materials, camera_group: CameraGroup) -> Shot:
    """The pixels of some cameras."""
    triangles = drawn.triangles
    shape = parts.shape.take(triangles)
    places = (camera_group.views, drawn.ends, drawn.pixels, drawn.row, drawn.column, drawn.inverse, drawn.depth)
    segments = (parts.segments, parts.link.take(triangles))
    if not camera_group.is_lit:
        return Shot(*places, *segments, _DULL, None, shape)
    glossy = materials.is_glossy.take(shape).nonzero()[0] if materials.is_glossy.any() else _NONE
    colors, gloss = materials.colors.take(shape, axis=1), materials.gloss.take(shape.take(glossy), axis=1)
    if materials.patterns:
        factors = _patterns(drawn, materials.pattern.take(shape), materials, camera_group)
        colors *= factors
        gloss *= factors.take(glossy, axis=1)
    return Shot(
        *places,
        *segments,
        colors,
        drawn.normals(),
        shape,
        glossy=glossy,
        gloss=gloss,
        shining=materials.shines.take(shape).nonzero()[0] if materials.shines.any() else _NONE,
        opacity=materials.opacity.take(shape[drawn.ends[len(camera_group.views)] :]),
        shades=drawn.surface([0], slice(None))[0] if parts.surface.shape[1] else None,
    )


def _patterns(drawn: Drawn, pattern: NDArray[np.int64], materials: Materials, camera_group: CameraGroup) -> NDArray[np.float32]:
    """Factors (3, n) of the colours of pixels that see some patterns (n,), with mean 1."""
    factors = np.ones((3, len(pattern)), dtype=np.float32)
    patterned = (pattern >= 0).nonzero()[0]
    pattern = pattern.take(patterned)
    scales = np.array([-1.4 / view.intrinsics()[0, 0] for view in camera_group.views], dtype=np.float32)
    camera = np.repeat(np.arange(len(drawn.ends) - 1) % len(scales), np.diff(np.searchsorted(patterned, drawn.ends)))
    places, widths = drawn.surface([1, 2], patterned), drawn.depth.take(patterned) * scales.take(camera)
    for number, (texture, size) in enumerate(materials.patterns):
        own = (pattern == number).nonzero()[0] if len(materials.patterns) > 1 else slice(None)
        u, v = places[:, own] * np.float32(1.0 / size)
        texels = texture.indices(u, v, widths[own] * np.float32(texture.size / size))
        factors[:, patterned[own]] = texture.relative.take(texels, axis=1)
    return factors


class BulletRasterizer:
    """PyBullet's renderers: TinyRenderer, or OpenGL.

    Args:
        client: The physics server.
        room: Numbers of the bodies of the room, which OpenGL draws and which are left out.
    """

    def __init__(self, client: PhysicsClient, room: frozenset[int]) -> None:
        self._client, self._hardware = client, client.hardware
        self._room = np.array(sorted(room), dtype=np.int32)

    def shoot(self, camera_groups: Sequence[CameraGroup], lighting: Lighting, light: CameraView | None) -> Shooting:
        """Look through some cameras, and through `light`, the camera of a light."""
        return BulletShooting(self, camera_groups, lighting, light)

    def shot(self, camera_group: CameraGroup, limit: NDArray[np.float32] | None, lighting: Lighting) -> Shot:
        """Return what some cameras see before a depth (n,) [m]."""
        ends = np.cumsum([0, *(view.size[0] * view.size[1] for view in camera_group.views)])
        limits = [None if limit is None else limit[a:b] for a, b in zip(ends, ends[1:])]
        each = [self._pixels(view, own, camera_group, lighting) for view, own in zip(camera_group.views, limits, strict=True)]
        pixels, inverse, depth, segments, colors = (np.concatenate(values, axis=-1) for values in zip(*each, strict=True))
        counts = [len(own[0]) for own in each]
        widths = np.repeat([view.size[0] for view in camera_group.views], counts)
        row, column = pixels // widths, pixels % widths
        pixels += np.repeat(ends[:-1], counts)
        places = (np.cumsum([0, *counts]), pixels, row.astype(np.float32), column.astype(np.float32), inverse, depth)
        return Shot(camera_group.views, *places, segments, np.arange(len(pixels)), colors, None, segments.astype(np.int64))

    def _pixels(
        self, view: CameraView, limit: NDArray[np.float32] | None, camera_group: CameraGroup, lighting: Lighting
    ) -> tuple[NDArray, ...]:
        """Pixels, inverse depths, depths, segments and colours (3, n) of what one camera sees."""
        if self._hardware and view.near < _HARDWARE_NEAR < view.far:
            view = replace(view, near=_HARDWARE_NEAR)
        colors, buffer, segments = self._camera_image(view, camera_group, lighting)
        segments = np.reshape(segments, -1)
        moving = segments >= 0
        if self._hardware:
            moving &= ~np.isin(bodies_of(segments), self._room)
        pixels = np.flatnonzero(moving)
        near, far = view.near, view.far
        precise = (far - (far - near) * np.reshape(buffer, -1)[pixels].astype(np.float64)) / (near * far)
        depth = (1.0 / precise).astype(np.float32)
        seen = depth < (view.far if limit is None else limit[pixels] + TOUCHING)
        pixels, inverse, depth = pixels[seen], precise[seen].astype(np.float32), depth[seen]
        rgb = np.reshape(colors, (-1, 4))[pixels, :3].T.astype(np.float32)
        return pixels, inverse, depth, segments[pixels], rgb

    def _camera_image(self, view: CameraView, camera_group: CameraGroup, lighting: Lighting) -> tuple[NDArray, NDArray, NDArray]:
        """Colours, depth buffer and segments; OpenGL prints a line at every change of size."""
        key = lighting.key.intensity if camera_group.is_lit else 0.0
        with captured_output() if self._hardware else nullcontext():
            images = bullet.getCameraImage(
                *view.size,
                viewMatrix=view.gl_view,
                projectionMatrix=projection_matrix(view, self._hardware),
                lightDirection=lighting.key.direction if camera_group.is_lit else (0.0, 0.0, 1.0),
                lightColor=(1.0, 1.0, 1.0),
                lightAmbientCoeff=camera_group.ambient,
                lightDiffuseCoeff=key,
                lightSpecularCoeff=SPECULAR if key else 0.0,
                shadow=0,
                renderer=bullet.ER_BULLET_HARDWARE_OPENGL if self._hardware else bullet.ER_TINY_RENDERER,
                flags=bullet.ER_SEGMENTATION_MASK_OBJECT_AND_LINKINDEX,
                physicsClientId=self._client.id,
            )[2:]
        if bullet.isNumpyEnabled():
            return images
        # pybullet-arm64 gives tuples of numbers; a third of the time of np.array.
        colors, depths, segments = images
        return np.frombuffer(bytes(colors), np.uint8), np.array(array("f", depths)), np.array(array("i", segments))


class BulletShooting:
    """Drawn by PyBullet.

    Args:
        rasterizer: The renderer.
        camera_groups: The groups of cameras.
        lighting: The lights.
        light: Camera of a light, if one looks.
    """

    def __init__(
        self, rasterizer: BulletRasterizer, camera_groups: Sequence[CameraGroup], lighting: Lighting, light: CameraView | None
    ) -> None:
        self._rasterizer, self._camera_groups, self._lighting, self._light = rasterizer, camera_groups, lighting, light
        self.lamps: Sequence[Lamp] = ()

    def shot(self, number: int, limit: NDArray[np.float32] | None) -> Shot:
        """Return what a group of cameras sees."""
        return self._rasterizer.shot(self._camera_groups[number], limit, self._lighting)

    def blocked(self) -> Blocked:
        """Return what stands in the light."""
        assert self._light is not None
        shot = self._rasterizer.shot(CameraGroup([self._light]), None, self._lighting)
        width, height = self._light.size
        depth = np.full(width * height, np.inf, dtype=np.float32)
        depth[shot.pixels] = shot.depth
        return Blocked(0, 0, depth.reshape(height, width))
