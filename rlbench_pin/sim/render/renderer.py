"""Pictures: moving things by PyBullet's renderer, the room by the backdrop, shadows and fill lights on top.

A separate drawing of the room saves most work: a camera that stands still draws it once. Where a moving thing is nearer than the
room it is seen; this is exact to the pixel. Shadows come from one picture taken from the key light. The fill lights follow from
the slopes of the depth.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.bodies.room import RoomBody
from rlbench_pin.sim.client import PhysicsClient, bullet
from rlbench_pin.sim.render.backdrop import Backdrop, Painter
from rlbench_pin.sim.render.camera import CameraView, Pictures, projection_matrix
from rlbench_pin.sim.render.lighting import Lighting
from rlbench_pin.sim.render.link_texture import LinkTexture, colors_of
from rlbench_pin.sim.render.shadows import LightSpots, ShadowMap, light_view, spots_of
from rlbench_pin.sim.render.surfaces import normals_at, points_at
from rlbench_pin.sim.server.output import captured_output
from rlbench_pin.values import as_flag, as_record

_LINK_SHIFT = 24  # a segmentation value is body + (link + 1) << 24
_BODY_BITS = (1 << _LINK_SHIFT) - 1
_KEPT = 12
_SPECULAR = 0.05
_HARDWARE_NEAR = 0.03  # its depth has so few bits that a nearer plane would cost millimetres [m]
_TOUCHING = np.float32(1e-5)  # [m]


@dataclass(frozen=True, eq=False)
class _Shot:
    """Moving things as the renderer saw them; flat arrays over those pixels."""

    pixels: NDArray[np.int64]
    colors: NDArray[np.uint32]
    inverse: NDArray[np.float32]
    depth: NDArray[np.float32]
    segments: NDArray[np.int32]


class _KeptBackdrop:
    """The room as one camera sees it, and where its pixels lie in the light."""

    def __init__(self, picture: Backdrop) -> None:
        self.picture = picture
        self.inverse = 1.0 / picture.depth
        self._spots: LightSpots | None = None

    def spots(self, view: CameraView, light: CameraView) -> LightSpots:
        if self._spots is None:
            depth = self.picture.depth.ravel()
            self._spots = spots_of(light, points_at(view, np.arange(depth.size), depth))
        return self._spots


class Renderer:
    """Takes the pictures of one world.

    Args:
        client: The physics server.
        room: What the backdrop draws.
        room_ids: Mask id of each room body.
        ids: Returns the mask ids of body b and link l at `[b, l + 1]`.
        hardware: Draw moving things with OpenGL instead of TinyRenderer.

    Attributes:
        lighting: The lights; may be replaced at any time.
    """

    def __init__(
        self,
        client: PhysicsClient,
        room: Mapping[str, RoomBody],
        room_ids: Mapping[str, int],
        ids: Callable[[], NDArray[np.int32]],
        hardware: bool = False,
    ) -> None:
        self._client, self._room, self._room_ids, self._ids, self._hardware = client, room, room_ids, ids, hardware
        self._room_numbers = np.array(sorted(body.model.uid for body in room.values()), dtype=np.int32)
        self.lighting = Lighting()
        self._link_textures: dict[tuple[int, int], LinkTexture] = {}
        self._painter: tuple[tuple[object, ...], Painter] | None = None
        self._backdrops: OrderedDict[tuple[object, ...], _KeptBackdrop | None] = OrderedDict()

    def set_link_texture(self, body: int, link: int, texture: LinkTexture) -> None:
        """Draw a texture over one link.

        Args:
            body: PyBullet's number of the body.
            link: PyBullet's number of the link.
            texture: What to draw.
        """
        self._link_textures[body, link] = texture

    def clear_link_texture(self, body: int, link: int) -> None:
        """Draw no texture over one link; the numbers are PyBullet's."""
        self._link_textures.pop((body, link), None)

    def clear_link_textures(self) -> None:
        """Draw no textures over links."""
        self._link_textures.clear()

    def shadow_map(self) -> ShadowMap:
        """Look from the key light, for all cameras that look at the present instant."""
        view = light_view(self.lighting.key)
        depth = np.full(view.size[0] * view.size[1], view.far, dtype=np.float32)
        shot = self._shoot(view, depth, 1.0, 0.0)
        depth[shot.pixels] = shot.depth
        return ShadowMap(view, depth.reshape(view.size))

    def render(self, view: CameraView, *, rgb: bool, depth: bool, mask: bool, shadows: bool | ShadowMap) -> Pictures:
        """Take pictures.

        Args:
            view: The camera.
            rgb: Deliver colours.
            depth: Deliver metric depth.
            mask: Deliver mask ids.
            shadows: Draw shadows and fill lights; a map from `shadow_map` of this instant saves making one.
        """
        backdrop = self._backdrop(as_record(view, CameraView, "camera"))
        rgb, depth, mask = (as_flag(wanted, what) for wanted, what in ((rgb, "rgb"), (depth, "depth"), (mask, "mask")))
        shadows = shadows if isinstance(shadows, ShadowMap) else as_flag(shadows, "shadows")
        room = backdrop.picture
        lighting, full = self.lighting, shadows is not False
        light = self.shadow_map() if shadows is True and rgb else shadows or None
        ambient = lighting.ambient if full else lighting.ambient + lighting.mean_fill
        shot = self._shoot(view, room.depth.ravel(), ambient, lighting.key.intensity)
        height, width = room.depth.shape
        image = distance = ids = None
        if rgb:
            flat = room.lit.copy().ravel()
            flat[shot.pixels] = shot.colors
            if full or self._link_textures:
                self._shade(flat, view, backdrop, shot, light if isinstance(light, ShadowMap) else None)
            image = np.ascontiguousarray(flat.view(np.uint8).reshape(height, width, 4)[..., :3])
        if depth:
            distance = room.depth.copy()
            distance.ravel()[shot.pixels] = shot.depth
        if mask:
            ids = room.mask.copy()
            ids.ravel()[shot.pixels] = self._ids()[shot.segments & _BODY_BITS, shot.segments >> _LINK_SHIFT]
        return Pictures(image, distance, ids)

    # Moving things ---------------------------------------------------------------------------------------------------

    def _shoot(self, view: CameraView, limit: NDArray[np.float32], ambient: float, key: float) -> _Shot:
        """Draw moving things where they are nearer than `limit` (h * w,) [m]."""
        if self._hardware and view.near < _HARDWARE_NEAR < view.far:
            view = replace(view, near=_HARDWARE_NEAR)
        colors, buffer, segments = self._camera_image(view, ambient, key)
        segments = np.reshape(segments, -1)
        moving = segments >= 0
        if self._hardware:
            moving &= ~np.isin(segments & _BODY_BITS, self._room_numbers)
        pixels = np.flatnonzero(moving)
        near, far = view.near, view.far
        inverse = (far - (far - near) * np.reshape(buffer, -1)[pixels].astype(np.float64)) / (near * far)
        depth = (1.0 / inverse).astype(np.float32)
        seen = depth < limit[pixels] + _TOUCHING
        if not seen.all():
            pixels, inverse, depth = pixels[seen], inverse[seen], depth[seen]
        packed = np.reshape(colors, (-1, 4)).view(np.uint32).ravel()[pixels]
        return _Shot(pixels, packed, inverse.astype(np.float32), depth, segments[pixels])

    def _camera_image(self, view: CameraView, ambient: float, key: float) -> tuple[NDArray, NDArray, NDArray]:
        """Colours, depth buffer and segments; OpenGL prints a line at every change of size."""
        with captured_output() if self._hardware else nullcontext():
            return bullet.getCameraImage(
                *view.size,
                viewMatrix=view.gl_view,
                projectionMatrix=projection_matrix(view, self._hardware),
                lightDirection=self.lighting.key.direction,
                lightColor=(1.0, 1.0, 1.0),
                lightAmbientCoeff=ambient,
                lightDiffuseCoeff=key,
                lightSpecularCoeff=_SPECULAR if key else 0.0,
                shadow=0,
                renderer=bullet.ER_BULLET_HARDWARE_OPENGL if self._hardware else bullet.ER_TINY_RENDERER,
                flags=bullet.ER_SEGMENTATION_MASK_OBJECT_AND_LINKINDEX,
                physicsClientId=self._client.id,
            )[2:]

    # Light -----------------------------------------------------------------------------------------------------------

    def _shade(
        self, image: NDArray[np.uint32], view: CameraView, backdrop: _KeptBackdrop, shot: _Shot, shadows: ShadowMap | None
    ) -> None:
        """Add shadows, fill lights and textures to an image (h * w,)."""
        if shadows is not None and not shadows.is_empty:
            lit = shadows.lit(backdrop.spots(view, shadows.view))
            lit[shot.pixels] = 1.0
            pixels = np.flatnonzero(lit < 1.0)
            room = backdrop.picture
            image[pixels] = _mixed(room.dark.ravel()[pixels], room.lit.ravel()[pixels], lit[pixels])
        if len(shot.pixels) == 0:
            return
        inverse = backdrop.inverse.copy()
        inverse.ravel()[shot.pixels] = shot.inverse
        normals = normals_at(view, shot.pixels, inverse)
        points = points_at(view, shot.pixels, shot.depth)
        colors = _unpacked(shot.colors)
        if shadows is not None:
            colors *= self._light_factor(points, normals, shadows)
        for (body, link), texture in self._link_textures.items():
            chosen = np.flatnonzero(shot.segments == body + ((link + 1) << _LINK_SHIFT))
            if len(chosen):
                size = shot.depth[chosen] / np.float32(-view.intrinsics()[0, 0])
                colors[chosen] *= colors_of(texture, self._frame(body, link), points[chosen], normals[chosen], size)
        image[shot.pixels] = _packed(colors)

    def _light_factor(self, points: NDArray, normals: NDArray, shadows: ShadowMap) -> NDArray[np.float32]:
        """By how much brighter (n, 3) or (n, 1) points are than ambient and unshaded key light make them."""
        lighting = self.lighting
        cosine = np.maximum(normals @ lighting.key.unit.astype(np.float32), 0.0)
        tangent = np.sqrt(1.0 - np.minimum(cosine, 1.0) ** 2) / np.maximum(cosine, 0.15)
        lit = shadows.lit(spots_of(shadows.view, points), 0.006 + 0.008 * tangent)
        key = cosine * np.float32(lighting.key.intensity)
        plain = np.float32(lighting.ambient) + key
        if lighting.is_white:
            fills = sum(fill.on(normals) for fill in lighting.fills)
            return ((lighting.ambient + key * lit + fills) / plain).astype(np.float32)[:, None]
        tint = np.array(lighting.key.color, dtype=np.float32)
        total = np.float32(lighting.ambient) * (tint * 0.5 + 0.5) + (key * lit)[:, None] * tint
        for fill in lighting.fills:
            total = total + fill.on(normals)[:, None] * np.array(fill.color, dtype=np.float32)
        return total / plain[:, None]

    def _frame(self, body: int, link: int) -> NDArray[np.float32]:
        identifier = self._client.id
        if link < 0:
            position, quaternion = bullet.getBasePositionAndOrientation(body, physicsClientId=identifier)
        else:
            position, quaternion = bullet.getLinkState(body, link, physicsClientId=identifier)[4:6]
        frame = np.eye(4, dtype=np.float32)
        frame[:3, :3] = np.reshape(bullet.getMatrixFromQuaternion(quaternion), (3, 3))
        frame[:3, 3] = position
        return frame

    # Room ------------------------------------------------------------------------------------------------------------

    def _backdrop(self, view: CameraView) -> _KeptBackdrop:
        """The room as a camera sees it; kept from the second time on that the same is asked."""
        appearance = (self.lighting, *(body.appearance() for body in self._room.values()))
        if self._painter is None or self._painter[0] != appearance:
            panels = [panel for name, body in self._room.items() for panel in body.panels(self._room_ids[name])]
            self._painter = appearance, Painter(panels, self.lighting)
            self._backdrops.clear()
        key = view.key
        kept = self._backdrops.get(key)
        if kept is not None:
            self._backdrops.move_to_end(key)
            return kept
        made = _KeptBackdrop(self._painter[1].draw(view))
        self._backdrops[key] = made if key in self._backdrops else None
        self._backdrops.move_to_end(key)
        while len(self._backdrops) > _KEPT:
            self._backdrops.popitem(last=False)
        return made


def _unpacked(colors: NDArray[np.uint32]) -> NDArray[np.float32]:
    """Colours (n, 3) in 0..255."""
    return np.ascontiguousarray(colors).view(np.uint8).reshape(-1, 4)[:, :3].astype(np.float32)


def _packed(colors: NDArray[np.float32]) -> NDArray[np.uint32]:
    rgba = np.full((len(colors), 4), 255, dtype=np.uint8)
    rgba[:, :3] = np.clip(colors + np.float32(0.5), 0.0, 255.0)
    return rgba.view(np.uint32).ravel()


def _mixed(dark: NDArray[np.uint32], bright: NDArray[np.uint32], share: NDArray[np.float32]) -> NDArray[np.uint32]:
    low, high = _unpacked(dark), _unpacked(bright)
    return _packed(low + (high - low) * share[:, None])
