"""Textures in place of the colours of robot, bodies and room, and the way back to their own looks."""

from __future__ import annotations

from collections.abc import Mapping

from rlbench_pin.sim.bodies.body import Body, Color, visual_colors
from rlbench_pin.sim.bodies.model import LoadedModel
from rlbench_pin.sim.bodies.room import RoomBody
from rlbench_pin.sim.client import bullet
from rlbench_pin.sim.render.renderer import Renderer
from rlbench_pin.sim.render.surfaces import LinkTexture
from rlbench_pin.sim.render.texture import Texture

_WHITE, _UNSEEN = (1.0, 1.0, 1.0, 1.0), (1.0, 1.0, 1.0, 0.0)


class TextureOverrides:
    """Textures over everything that is drawn; bodies keep their own colours, which `clear` shows again.

    Args:
        renderer: Draws the textures.
        robot: Model of the arm.
        bodies: Bodies of the scene, by name.
        room: Bodies of the room, by name.
    """

    def __init__(self, renderer: Renderer, robot: LoadedModel, bodies: Mapping[str, Body], room: Mapping[str, RoomBody]) -> None:
        self._renderer, self._robot, self._bodies, self._room = renderer, robot, bodies, room
        self._robot_colors = visual_colors(robot)
        self._white_robot_links: set[int] = set()
        self._hidden_robot_links: set[int] = set()
        self._painted_robot_links: dict[int, Color] = {}
        self._white_bodies: set[str] = set()

    @property
    def robot_links(self) -> tuple[int, ...]:
        """Numbers of the arm's links that have visuals."""
        return tuple(sorted(self._robot_colors))

    def set_robot_link(self, link: int, texture: Texture, repeats: float) -> None:
        """Put a texture on a link of the arm in place of its colours.

        Args:
            link: Number of the link, one of `robot_links`.
            texture: The picture.
            repeats: How often it repeats along one metre.
        """
        self._white_robot_links.add(link)
        self._repaint_robot_link(link)
        self._renderer.set_link_texture(self._robot.uid, link, LinkTexture(texture, repeats))

    def show_robot_link(self, link: int, shown: bool) -> None:
        """Hide a link of the arm from cameras, or show it again; what has no visuals stays as it is.

        Args:
            link: Number of the link.
            shown: Whether it is seen from now on.
        """
        if link not in self._robot_colors:
            return
        if not shown:
            self._hidden_robot_links.add(link)
        elif link in self._hidden_robot_links:
            self._hidden_robot_links.remove(link)
        self._repaint_robot_link(link)

    def robot_link_color(self, link: int) -> Color:
        """Colour rgba in 0..1 of a link of the arm: the one given to it, or that of its first visual."""
        return self._painted_robot_links.get(link) or self._robot_colors.get(link, (_WHITE,))[0]

    def paint_robot_link(self, link: int, color: Color) -> None:
        """Give a link of the arm one colour rgba in 0..1 for all its visuals; those without visuals stay as they are."""
        if link in self._robot_colors:
            self._painted_robot_links[link] = color
            self._repaint_robot_link(link)

    def set_body(self, name: str, texture: Texture, repeats: float) -> None:
        """Put a texture on a body; a body that was given a colour keeps it, and the texture only shades it.

        Args:
            name: Name of a body of the scene.
            texture: The picture.
            repeats: How often it repeats along one metre.
        """
        body = self._bodies[name]
        colored = bool(body.colors)
        if not colored:
            self._white_bodies.add(name)
        for link in body.visual_links:
            if not colored:
                _whiten(body.model, link)
            self._renderer.set_link_texture(body.model.uid, link, LinkTexture(texture.gray if colored else texture, repeats))

    def set_room_body(self, name: str, texture: Texture) -> None:
        """Put a texture on table, floor, ceiling or a wall in place of its own."""
        self._room[name].texture = texture

    def clear_body(self, name: str) -> None:
        """Give one body its own looks back; parts of the room are left alone."""
        if (body := self._bodies.get(name)) is None:
            return
        for link in body.visual_links:
            self._renderer.clear_link_texture(body.model.uid, link)
        if name in self._white_bodies:
            self._white_bodies.remove(name)
            body.repaint()

    def clear_room_body(self, name: str) -> None:
        """Give table, floor, ceiling or a wall its own texture back."""
        self._room[name].texture = None

    def clear_robot_link(self, link: int) -> None:
        """Give one link of the arm its own colours back."""
        self._renderer.clear_link_texture(self._robot.uid, link)
        if link in self._white_robot_links:
            self._white_robot_links.remove(link)
            self._repaint_robot_link(link)

    def _repaint_robot_link(self, link: int) -> None:
        for shape, color in enumerate(self._robot_colors[link]):
            if link in self._hidden_robot_links:
                color = _UNSEEN
            else:
                color = _WHITE if link in self._white_robot_links else self._painted_robot_links.get(link, color)
            bullet.changeVisualShape(
                self._robot.uid, link, shapeIndex=shape, rgbaColor=color, physicsClientId=self._robot.client.id
            )

    def apply_again(self) -> None:
        """Apply the present overrides in a physics server that was built again."""
        for link in {*self._white_robot_links, *self._hidden_robot_links, *self._painted_robot_links}:
            self._repaint_robot_link(link)
        for name in self._white_bodies & set(self._bodies):
            for link in self._bodies[name].visual_links:
                _whiten(self._bodies[name].model, link)

    def clear(self) -> None:
        """Remove all overrides, so that everything has its own colours and textures again."""
        self._renderer.clear_link_textures()
        for body in self._room.values():
            body.texture = None
        for name in self._white_bodies & set(self._bodies):
            self._bodies[name].repaint()
        links, self._white_bodies, self._white_robot_links = self._white_robot_links, set(), set()
        for link in links:
            self._repaint_robot_link(link)


def _whiten(model: LoadedModel, link: int) -> None:
    bullet.changeVisualShape(model.uid, link, rgbaColor=_WHITE, physicsClientId=model.client.id)
