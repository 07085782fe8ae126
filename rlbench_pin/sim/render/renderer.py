"""Images: moving objects drawn over the room, with shadows and fill lights on top.

A separate drawing of the room saves most work, because a stationary camera draws it once. A moving object is visible where it is
nearer than the room; this is exact to the pixel. Moving objects are drawn for all cameras together, and for the key light, whose
image gives the shadows. The fill lights follow from the slopes of the depth.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.client import PhysicsClient, bullet
from rlbench_pin.sim.render.backdrop import Painter
from rlbench_pin.sim.render.camera import CameraView, Images
from rlbench_pin.sim.render.lighting import Lighting, ShadowMap, light_view
from rlbench_pin.sim.render.raster.drawing import CameraGroup
from rlbench_pin.sim.render.raster.stage import Appearance, Lamp
from rlbench_pin.sim.render.shading import (
    KeptBackdrop,
    LinkTexture,
    Sheet,
    bytes_of,
    colors_in_light,
    halved,
    normals_of_depth,
    put_textures,
)
from rlbench_pin.sim.render.shots import BulletRasterizer, NumpyRasterizer, NumpyShooting, Shooting, Shot
from rlbench_pin.sim.render.stationary_links import StationaryLinks, stationary_links
from rlbench_pin.sim.room import RoomBody
from rlbench_pin.values import as_flag, as_record

_KEPT = 12


@dataclass(frozen=True, eq=False)
class Request:
    """Requested products of one camera."""

    view: CameraView
    """The camera."""
    rgb: bool = True
    """Deliver colours."""
    depth: bool = True
    """Deliver metric depth."""
    mask: bool = True
    """Deliver mask ids."""
    shadows: bool = False
    """Draw shadows and fill lights."""
    antialiasing: bool = False
    """Smooth the edges between surfaces; depth and mask stay the same."""
    fine: bool = False
    """Take each colour as the mean of two by two; depth and mask stay the same."""

    def parts(self) -> tuple[Request, ...]:
        """The drawings for it: itself, or its colours at twice the size, and depth and mask if they are requested."""
        if not (self.fine and self.rgb):
            return (self,)
        colors = replace(self, view=self.view.finer, depth=False, mask=False, fine=False)
        rest = Request(self.view, rgb=False, depth=self.depth, mask=self.mask)
        return (colors, rest) if self.depth or self.mask else (colors,)

    @property
    def is_shaded(self) -> bool:
        """Whether the image has shadows."""
        return self.rgb and self.shadows


class Renderer:
    """Renderer of one world.

    Args:
        client: The physics server.
        room: The bodies of the room, which the backdrop draws.
        room_ids: Mask id of each room body.
        ids: Returns the mask ids of body b and link l at `[b, l + 1]`.
        appearance: Appearance of visuals that the server does not report.

    Attributes:
        lighting: The lights; may be replaced at any time.
    """

    def __init__(
        self,
        client: PhysicsClient,
        room: Mapping[str, RoomBody],
        room_ids: Mapping[str, int],
        ids: Callable[[], NDArray[np.int32]],
        appearance: Appearance,
    ) -> None:
        self._client, self._room, self._room_ids, self._ids = client, room, room_ids, ids
        self._appearance = appearance
        self.lighting = Lighting()
        self._link_textures: dict[tuple[int, int], LinkTexture] = {}
        self.forget()

    def forget(self) -> None:
        """Drop all cached drawings, for a replaced world: it can stay in memory until the next garbage collection."""
        client, numbers = self._client, frozenset(body.model.uid for body in self._room.values())
        self._rasterizer: BulletRasterizer | NumpyRasterizer = (
            BulletRasterizer(client, numbers) if client.hardware else NumpyRasterizer(client, numbers, self._appearance)
        )
        self._stationary_layout: tuple[object, ...] = ()
        self._stationary_key: tuple[object, ...] = ()
        self._stationary_links: StationaryLinks | None = None
        self._painter: tuple[tuple[object, ...], Painter] | None = None
        self._backdrops: OrderedDict[tuple[object, ...], KeptBackdrop | None] = OrderedDict()

    def set_link_texture(self, body: int, link: int, texture: LinkTexture) -> None:
        """Draw a texture over one link.

        Args:
            body: PyBullet's number of the body.
            link: PyBullet's number of the link.
            texture: The texture.
        """
        self._link_textures = {**self._link_textures, (body, link): texture}

    def clear_link_texture(self, body: int, link: int) -> None:
        """Remove the texture of one link; the numbers are PyBullet's."""
        self._link_textures = {place: own for place, own in self._link_textures.items() if place != (body, link)}

    def clear_link_textures(self) -> None:
        """Remove the textures of all links."""
        self._link_textures = {}

    def shadow_map(self) -> ShadowMap:
        """Return the shadow map of the key light at this instant."""
        view, height = self._view_of_light(), self._present_painter().table_height
        return ShadowMap(view, height, self._rasterizer.shoot([], self.lighting, view).blocked())

    def render(
        self, view: CameraView, *, rgb: bool, depth: bool, mask: bool, shadows: bool | ShadowMap, antialiasing: bool = False
    ) -> Images:
        """Render the images of one camera.

        Args:
            view: The camera.
            rgb: Return colours.
            depth: Return metric depth [m].
            mask: Return mask ids.
            shadows: Draw shadows and fill lights; a map from `shadow_map` of this instant is reused.
            antialiasing: Smooth the edges between surfaces.
        """
        as_record(view, CameraView, "camera")
        flags = ((rgb, "rgb"), (depth, "depth"), (mask, "mask"), (antialiasing, "antialiasing"))
        rgb, depth, mask, antialiasing = (as_flag(wanted, what) for wanted, what in flags)
        shadows = shadows if isinstance(shadows, ShadowMap) else as_flag(shadows, "shadows")
        light = shadows if isinstance(shadows, ShadowMap) else None
        return self.render_all([Request(view, rgb, depth, mask, shadows is not False, antialiasing)], light)[0]

    def image(self, view: CameraView) -> NDArray[np.uint8]:
        """Return an image for display, uint8 (h, w, 3): with shadows, antialiasing and supersampling."""
        as_record(view, CameraView, "camera")
        image = self.render_all([Request(view, depth=False, mask=False, shadows=True, antialiasing=True, fine=True)])[0].rgb
        assert image is not None
        return image

    def render_all(self, requests: Sequence[Request], shadows: ShadowMap | None = None) -> list[Images]:
        """Render the images of several cameras at this instant: the same images as one by one, in less time.

        Args:
            requests: The cameras and the requested images.
            shadows: The shadows, from `shadow_map` of this instant; None computes them if needed.
        """
        parts = [request.parts() for request in requests]
        taken = iter(self._take([part for group in parts for part in group], shadows))
        return [_joined(request, [next(taken) for _ in group]) for request, group in zip(requests, parts, strict=True)]

    def _take(self, requests: Sequence[Request], shadows: ShadowMap | None) -> list[Images]:
        """Render the images of some cameras at their own size."""
        if not requests:
            return []
        painter = self._present_painter()
        kinds = [(request.rgb, request.is_shaded) for request in requests]
        groups = [[n for n, own in enumerate(kinds) if own == kind] for kind in sorted(set(kinds))]
        wanted = [[requests[n] for n in group] for group in groups]
        rooms = [[self._backdrop(painter, request.view) for request in group] for group in wanted]
        camera_groups = [self._camera_group(group) for group in wanted]
        makes_map = shadows is None and any(request.is_shaded for request in requests)
        light = self._view_of_light()
        shooting = self._rasterizer.shoot(camera_groups, self.lighting, light if makes_map else None)
        taken: dict[int, Images] = {}
        for number, (group, own, room) in enumerate(zip(groups, wanted, rooms, strict=True)):
            near, first = None, own[0]
            stationary = self._kept_links(shooting, number, room, painter) if first.is_shaded else None
            sheet = Sheet(
                room if stationary is None else stationary.before(room), first.rgb, any(request.mask for request in own)
            )
            if stationary is not None and isinstance(shooting, NumpyShooting):
                shot, shadows, near = stationary.moving(shooting, number, sheet.depth)
            else:
                shot = shooting.shot(number, sheet.depth)
                if first.is_shaded and makes_map:
                    shadows = ShadowMap(light, painter.table_height, shooting.blocked())
            sheet.put_depth_and_ids(shot, self._ids())
            if first.rgb:
                if first.shadows and shadows is not None:
                    sheet.shade_tables(shadows, painter.table_key, near)
                    if shooting.lamps:
                        sheet.put_pools(shadows, shooting.lamps)
                sheet.put_colors(shot, self._colors(sheet, shot, shadows if first.shadows else None, shooting.lamps))
                sheet.smooth([n for n, request in enumerate(own) if request.antialiasing])
            taken.update(zip(group, _images(own, sheet), strict=True))
        return [taken[n] for n in range(len(requests))]

    # Moving objects ---------------------------------------------------------------------------------------------------

    def _view_of_light(self) -> CameraView:
        x, y, z = self.lighting.key.direction
        return light_view((x, y, z))

    def _camera_group(self, requests: Sequence[Request]) -> CameraGroup:
        lighting, first = self.lighting, requests[0]
        ambient = lighting.ambient if first.is_shaded else lighting.ambient + lighting.mean_fill
        return CameraGroup([request.view for request in requests], first.rgb, ambient)

    def _kept_links(
        self, shooting: Shooting, number: int, backdrops: Sequence[KeptBackdrop], room: Painter
    ) -> StationaryLinks | None:
        """Stationary links in front of the room, cached from the second unchanged image on."""
        if not isinstance(shooting, NumpyShooting) or shooting.state is None or shooting.lamps:
            return None
        ids = self._ids()
        layout = (number, *(backdrop.view.size for backdrop in backdrops))
        key = (room, ids, self._link_textures, *shooting.state)
        is_same = layout == self._stationary_layout and len(key) == len(self._stationary_key)
        if not is_same or any(now is not before for now, before in zip(key, self._stationary_key)):
            self._stationary_layout, self._stationary_key, self._stationary_links = layout, key, None
        elif self._stationary_links is None:
            light = self._view_of_light()
            self._stationary_links = stationary_links(shooting, number, backdrops, room, self._colors, light, ids)
        return self._stationary_links

    def _colors(self, sheet: Sheet, shot: Shot, shadows: ShadowMap | None, lamps: Sequence[Lamp] = ()) -> NDArray[np.uint8]:
        """Return the colours (n, 3) of objects before the room, with shadows, fill lights and textures."""
        normals = normals_of_depth(sheet.backdrops, shot) if shot.normals is None else shot.normals
        colors = colors_in_light(shot, normals, self.lighting, shadows, lamps)
        if self._link_textures:
            put_textures(colors, shot, normals, self._link_textures, self._frame)
        return bytes_of(colors)

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

    def _present_painter(self) -> Painter:
        """Return the backdrop of the current room; those of other rooms are dropped."""
        appearance = (self.lighting, *(body.appearance() for body in self._room.values()))
        if self._painter is None or self._painter[0] != appearance:
            panels = [panel for name, body in self._room.items() for panel in body.panels(self._room_ids[name])]
            self._painter = appearance, Painter(panels, self.lighting)
            self._backdrops.clear()
        return self._painter[1]

    def _backdrop(self, painter: Painter, view: CameraView) -> KeptBackdrop:
        """Image of the room from a camera; cached from the second equal request on."""
        key = view.key
        kept = self._backdrops.get(key)
        if kept is not None:
            self._backdrops.move_to_end(key)
            return kept
        made = KeptBackdrop(view, painter.draw(view))
        self._backdrops[key] = made if key in self._backdrops else None
        self._backdrops.move_to_end(key)
        while len(self._backdrops) > _KEPT:
            self._backdrops.popitem(last=False)
        return made


def _images(requests: Sequence[Request], sheet: Sheet) -> list[Images]:
    """Return the requested images of some cameras."""
    return [
        Images(
            sheet.part(sheet.bytes, n) if request.rgb else None,
            sheet.part(sheet.depth, n) if request.depth else None,
            sheet.part(sheet.ids, n) if request.mask else None,
        )
        for n, request in enumerate(requests)
    ]


def _joined(request: Request, parts: Sequence[Images]) -> Images:
    """Return the images of a request from those of its parts."""
    if parts[0].rgb is None or not request.fine:
        return parts[0]
    return replace(parts[-1], rgb=halved(parts[0].rgb))
