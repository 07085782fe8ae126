"""What cameras see of moving things: drawn by numpy for all of them at once, or by PyBullet's renderers one after the other."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.client import PhysicsClient, bullet
from rlbench_pin.sim.render.camera import CameraView, projection_matrix
from rlbench_pin.sim.render.lighting import Light
from rlbench_pin.sim.render.masks import bodies_of
from rlbench_pin.sim.render.raster.drawing import Drawn, draw
from rlbench_pin.sim.render.raster.stage import MixedColors, Parts, Stage
from rlbench_pin.sim.server.output import captured_output

_SPECULAR = 0.05
_HARDWARE_NEAR = 0.03  # its depth has so few bits that a nearer plane would cost millimetres [m]
_TOUCHING = np.float32(1e-5)  # [m]


@dataclass(frozen=True, eq=False)
class Sight:
    """A camera, and what hides moving things from it."""

    view: CameraView
    limit: NDArray[np.float32]
    """Depth (h * w,) from which on nothing is seen [m]."""
    light: Light | None = None
    """Key light; None when no colours are wanted."""
    ambient: float = 1.0
    """Brightness where it does not reach."""


@dataclass(frozen=True, eq=False)
class Shot:
    """The pixels of one picture that see moving things, ascending."""

    pixels: NDArray[np.int64]
    """Flat indices (n,)."""
    colors: NDArray[np.float32]
    """Colours (n, 3) in 0..255, in ambient and key light; none when no colours were wanted."""
    inverse: NDArray[np.float32]
    """Inverse depth (n,) [1/m]."""
    depth: NDArray[np.float32]
    """(n,) [m]."""
    segments: NDArray[np.int32]
    """Segmentation values (n,)."""


class Rasterizer(Protocol):
    """Takes shots of the present instant."""

    def shoot(self, sights: Sequence[Sight]) -> list[Shot]:
        """Return one shot for each camera."""
        ...


class NumpyRasterizer:
    """Draws triangles with numpy; what has shapes that it cannot draw is left to TinyRenderer.

    Args:
        client: The physics server.
        room: Numbers of the bodies of the room.
        mixed_colors: Returns the colours of links whose visuals differ, by body and link number.
    """

    def __init__(self, client: PhysicsClient, room: frozenset[int], mixed_colors: MixedColors) -> None:
        self._stage, self._other = Stage(client, room, mixed_colors), BulletRasterizer(client, room)

    def shoot(self, sights: Sequence[Sight]) -> list[Shot]:
        """Return one shot for each camera."""
        parts = self._stage.update()
        if parts is None:
            return self._other.shoot(sights)
        placements, colors = self._stage.placements(), self._stage.colors
        drawn = draw(parts, colors[:, 3] > 0.0, placements, [sight.view for sight in sights])
        paint = np.floor(colors[:, :3] * np.float32(255.0))
        return [_shot(picture, sight, parts, paint) for picture, sight in zip(drawn, sights, strict=True)]


def _shot(drawn: Drawn, sight: Sight, parts: Parts, paint: NDArray[np.float32]) -> Shot:
    """Colour what a camera sees.

    Args:
        drawn: The pixels.
        sight: The camera.
        parts: The triangles.
        paint: Colour in 0..255 of every visual.
    """
    depth: NDArray[np.float32] = np.float32(1.0) / drawn.inverse
    pixels, inverse, triangles, normals = drawn.pixels, drawn.inverse, drawn.triangles, drawn.normals
    seen = depth < sight.limit[pixels] + _TOUCHING
    if not seen.all():
        depth, pixels, inverse, triangles, normals = depth[seen], pixels[seen], inverse[seen], triangles[seen], normals[:, seen]
    colors = np.zeros((0, 3), dtype=np.float32)
    if sight.light is not None:
        x, y, z = direction = sight.light.unit.astype(np.float32)
        brightness = _brightness(normals[0] * x + normals[1] * y + normals[2] * z, normals[2], direction[2], sight)
        colors = paint.take(parts.shape.take(triangles), axis=0)
        colors *= brightness[:, None]
        np.minimum(np.floor(colors, out=colors), np.float32(255.0), out=colors)
    return Shot(pixels, colors, inverse, depth, parts.segments.take(triangles))


def _brightness(cosine: NDArray[np.float32], up: NDArray[np.float32], light_up: np.float32, sight: Sight) -> NDArray[np.float32]:
    """Brightness (n,) in ambient and key light, with a highlight where what mirrors the light looks upwards.

    Args:
        cosine: Normals times direction to the light (n,).
        up: Normals times the vertical (n,).
        light_up: Direction to the light times the vertical.
        sight: The lights.
    """
    assert sight.light is not None
    mirrored = np.maximum(np.float32(2.0) * cosine * up - light_up, np.float32(0.0))
    key = np.maximum(cosine, np.float32(0.0)) * np.float32(sight.light.intensity)
    return np.float32(sight.ambient) + key + np.float32(_SPECULAR if sight.light.intensity else 0.0) * mirrored * mirrored


class BulletRasterizer:
    """PyBullet's renderers: TinyRenderer, or OpenGL.

    Args:
        client: The physics server.
        room: Numbers of the bodies of the room, which OpenGL draws and which are left out.
    """

    def __init__(self, client: PhysicsClient, room: frozenset[int]) -> None:
        self._client, self._hardware = client, client.hardware
        self._room = np.array(sorted(room), dtype=np.int32)

    def shoot(self, sights: Sequence[Sight]) -> list[Shot]:
        """Return one shot for each camera."""
        return [self._shot(sight) for sight in sights]

    def _shot(self, sight: Sight) -> Shot:
        view = sight.view
        if self._hardware and view.near < _HARDWARE_NEAR < view.far:
            view = replace(view, near=_HARDWARE_NEAR)
        colors, buffer, segments = self._camera_image(view, sight)
        segments = np.reshape(segments, -1)
        moving = segments >= 0
        if self._hardware:
            moving &= ~np.isin(bodies_of(segments), self._room)
        pixels = np.flatnonzero(moving)
        near, far = view.near, view.far
        precise = (far - (far - near) * np.reshape(buffer, -1)[pixels].astype(np.float64)) / (near * far)
        depth = (1.0 / precise).astype(np.float32)
        seen = depth < sight.limit[pixels] + _TOUCHING
        pixels, inverse, depth = pixels[seen], precise[seen].astype(np.float32), depth[seen]
        rgb = np.reshape(colors, (-1, 4))[pixels, :3].astype(np.float32)
        return Shot(pixels, rgb, inverse, depth, segments[pixels])

    def _camera_image(self, view: CameraView, sight: Sight) -> tuple[NDArray, NDArray, NDArray]:
        """Colours, depth buffer and segments; OpenGL prints a line at every change of size."""
        key = 0.0 if sight.light is None else sight.light.intensity
        with captured_output() if self._hardware else nullcontext():
            return bullet.getCameraImage(
                *view.size,
                viewMatrix=view.gl_view,
                projectionMatrix=projection_matrix(view, self._hardware),
                lightDirection=(0.0, 0.0, 1.0) if sight.light is None else sight.light.direction,
                lightColor=(1.0, 1.0, 1.0),
                lightAmbientCoeff=sight.ambient,
                lightDiffuseCoeff=key,
                lightSpecularCoeff=_SPECULAR if key else 0.0,
                shadow=0,
                renderer=bullet.ER_BULLET_HARDWARE_OPENGL if self._hardware else bullet.ER_TINY_RENDERER,
                flags=bullet.ER_SEGMENTATION_MASK_OBJECT_AND_LINKINDEX,
                physicsClientId=self._client.id,
            )[2:]
