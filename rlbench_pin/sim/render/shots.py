"""What cameras see of moving things: drawn by numpy for all of them at once, or by PyBullet's renderers one after the other."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.client import PhysicsClient, bullet
from rlbench_pin.sim.output import captured_output
from rlbench_pin.sim.render.camera import CameraView, projection_matrix
from rlbench_pin.sim.render.lighting import SPECULAR, Lighting
from rlbench_pin.sim.render.masks import bodies_of
from rlbench_pin.sim.render.raster.drawing import TOUCHING, Blocked, Drawn, Sight, draw
from rlbench_pin.sim.render.raster.stage import Appearance, Parts, Stage

_HARDWARE_NEAR = 0.03  # its depth has so few bits that a nearer plane would cost millimetres [m]


_NONE: NDArray[np.int64] = np.zeros(0, dtype=np.int64)
_DULL: NDArray[np.float32] = np.zeros((3, 0), dtype=np.float32)


@dataclass(frozen=True, eq=False)
class Shot:
    """The pixels of one image that see moving objects, ascending."""

    pixels: NDArray[np.int64]
    """Flat indices (n,)."""
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
    glossy: NDArray[np.int64] = field(default_factory=lambda: _NONE)
    """Which of the pixels see something glossy (k,)."""
    gloss: NDArray[np.float32] = field(default_factory=lambda: _DULL)
    """Share of red, green, blue that it throws back like a mirror (3, k)."""


class NumpyRasterizer:
    """Draws triangles with numpy; what has shapes that it cannot draw is left to TinyRenderer.

    Args:
        client: The physics server.
        room: Numbers of the bodies of the room.
        appearance: What the server does not tell.
    """

    def __init__(self, client: PhysicsClient, room: frozenset[int], appearance: Appearance) -> None:
        self._stage, self._other = Stage(client, room, appearance), BulletRasterizer(client, room)

    def shoot(self, sights: Sequence[Sight], lighting: Lighting, light: CameraView | None) -> tuple[list[Shot], Blocked | None]:
        """Return one shot for each camera, and what stands in a light, whose camera is `light`."""
        placed = self._stage.update()
        if placed is None:
            return self._other.shoot(sights, lighting, light)
        colors, shape = self._stage.colors, placed.parts.shape
        drawn, blocked = draw(placed, self._stage.layers, (colors[:, 3] > 0.0).take(shape), sights, light)
        paint = np.ascontiguousarray((colors[:, :3] * np.float32(255.0)).T)
        gloss = np.ascontiguousarray(self._stage.gloss.T)
        shots = [_shot(image, placed.parts, paint, gloss, sight.is_lit) for image, sight in zip(drawn, sights, strict=True)]
        return shots, blocked


def _shot(drawn: Drawn, parts: Parts, paint: NDArray[np.float32], gloss: NDArray[np.float32], is_lit: bool) -> Shot:
    """What a camera sees, in the colours (3, v) of the visuals in 0..255, and what of it is glossy (3, v)."""
    triangles = drawn.triangles
    shot = Shot(drawn.pixels, drawn.inverse, drawn.depth, parts.segments, parts.link.take(triangles), _DULL, drawn.normals)
    if not is_lit:
        return shot
    shape = parts.shape.take(triangles)
    is_glossy = gloss.any(axis=0)
    glossy = is_glossy.take(shape).nonzero()[0] if is_glossy.any() else _NONE
    return replace(shot, colors=paint.take(shape, axis=1), glossy=glossy, gloss=gloss.take(shape.take(glossy), axis=1))


class BulletRasterizer:
    """PyBullet's renderers: TinyRenderer, or OpenGL.

    Args:
        client: The physics server.
        room: Numbers of the bodies of the room, which OpenGL draws and which are left out.
    """

    def __init__(self, client: PhysicsClient, room: frozenset[int]) -> None:
        self._client, self._hardware = client, client.hardware
        self._room = np.array(sorted(room), dtype=np.int32)

    def shoot(self, sights: Sequence[Sight], lighting: Lighting, light: CameraView | None) -> tuple[list[Shot], Blocked | None]:
        """Return one shot for each camera, and what stands in a light, whose camera is `light`."""
        shots = [self._shot(sight, lighting) for sight in sights]
        return shots, None if light is None else self._blocked(light, lighting)

    def _blocked(self, light: CameraView, lighting: Lighting) -> Blocked:
        shot = self._shot(Sight(light, None), lighting)
        depth = np.full(light.size[0] * light.size[1], np.inf, dtype=np.float32)
        depth[shot.pixels] = shot.depth
        return Blocked(0, 0, depth.reshape(light.size[::-1]))

    def _shot(self, sight: Sight, lighting: Lighting) -> Shot:
        view = sight.view
        if self._hardware and view.near < _HARDWARE_NEAR < view.far:
            view = replace(view, near=_HARDWARE_NEAR)
        colors, buffer, segments = self._camera_image(view, sight, lighting)
        segments = np.reshape(segments, -1)
        moving = segments >= 0
        if self._hardware:
            moving &= ~np.isin(bodies_of(segments), self._room)
        pixels = np.flatnonzero(moving)
        near, far = view.near, view.far
        precise = (far - (far - near) * np.reshape(buffer, -1)[pixels].astype(np.float64)) / (near * far)
        depth = (1.0 / precise).astype(np.float32)
        seen = depth < (view.far if sight.limit is None else sight.limit[pixels] + TOUCHING)
        pixels, inverse, depth = pixels[seen], precise[seen].astype(np.float32), depth[seen]
        rgb = np.reshape(colors, (-1, 4))[pixels, :3].T.astype(np.float32)
        return Shot(pixels, inverse, depth, segments[pixels], np.arange(len(pixels)), rgb, None)

    def _camera_image(self, view: CameraView, sight: Sight, lighting: Lighting) -> tuple[NDArray, NDArray, NDArray]:
        """Colours, depth buffer and segments; OpenGL prints a line at every change of size."""
        key = lighting.key.intensity if sight.is_lit else 0.0
        with captured_output() if self._hardware else nullcontext():
            return bullet.getCameraImage(
                *view.size,
                viewMatrix=view.gl_view,
                projectionMatrix=projection_matrix(view, self._hardware),
                lightDirection=lighting.key.direction if sight.is_lit else (0.0, 0.0, 1.0),
                lightColor=(1.0, 1.0, 1.0),
                lightAmbientCoeff=sight.ambient,
                lightDiffuseCoeff=key,
                lightSpecularCoeff=SPECULAR if key else 0.0,
                shadow=0,
                renderer=bullet.ER_BULLET_HARDWARE_OPENGL if self._hardware else bullet.ER_TINY_RENDERER,
                flags=bullet.ER_SEGMENTATION_MASK_OBJECT_AND_LINKINDEX,
                physicsClientId=self._client.id,
            )[2:]
