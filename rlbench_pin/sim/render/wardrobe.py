"""Putting textures and plain colours on everything, and taking them off again."""

from __future__ import annotations

from collections.abc import Mapping

from rlbench_pin.sim.bodies.body import Body, visual_colors
from rlbench_pin.sim.bodies.model import LoadedModel
from rlbench_pin.sim.bodies.room import RoomBody
from rlbench_pin.sim.client import bullet
from rlbench_pin.sim.render.renderer import Renderer
from rlbench_pin.sim.render.skins import Skin
from rlbench_pin.sim.render.texture import Texture

_WHITE = (1.0, 1.0, 1.0, 1.0)


class Wardrobe:
    """Changes how things look without telling them, so that their own colours come back.

    Args:
        renderer: Draws the textures.
        robot: Model of the arm.
        bodies: Bodies of the scene, by name.
        room: Bodies of the room, by name.
    """

    def __init__(self, renderer: Renderer, robot: LoadedModel, bodies: Mapping[str, Body], room: Mapping[str, RoomBody]) -> None:
        self._renderer, self._robot, self._bodies, self._room = renderer, robot, bodies, room
        self._robot_colors = visual_colors(robot)
        self._plain_robot_links: set[int] = set()
        self._plain_bodies: set[str] = set()

    @property
    def robot_links(self) -> tuple[int, ...]:
        """Numbers of the arm's links that are seen."""
        return tuple(sorted(self._robot_colors))

    def dress_robot(self, link: int, texture: Texture, repeats: float) -> None:
        """Put a texture on a link of the arm in place of its colours."""
        self._plain_robot_links.add(link)
        _whiten(self._robot, link)
        self._renderer.skins[self._robot.uid, link] = Skin(texture, repeats)

    def dress_body(self, name: str, texture: Texture, repeats: float) -> None:
        """Put a texture on a body; a body that was given a colour keeps it, and the texture only shades it."""
        body = self._bodies[name]
        colored = bool(body.colors)
        if not colored:
            self._plain_bodies.add(name)
        for link in body.seen_links:
            if not colored:
                _whiten(body.model, link)
            self._renderer.skins[body.model.uid, link] = Skin(texture.gray if colored else texture, repeats)

    def dress_room(self, name: str, texture: Texture) -> None:
        """Put a texture on a body of the room in place of its own."""
        self._room[name].texture = texture

    def wear_again(self) -> None:
        """Make the present look in a physics server that was built again."""
        for link in self._plain_robot_links:
            _whiten(self._robot, link)
        for name in self._plain_bodies & set(self._bodies):
            for link in self._bodies[name].seen_links:
                _whiten(self._bodies[name].model, link)

    def undress(self) -> None:
        """Give everything its own look back."""
        self._renderer.skins.clear()
        for body in self._room.values():
            body.texture = None
        for name in self._plain_bodies & set(self._bodies):
            self._bodies[name].repaint()
        for link in self._plain_robot_links:
            for shape, color in enumerate(self._robot_colors[link]):
                bullet.changeVisualShape(
                    self._robot.uid, link, shapeIndex=shape, rgbaColor=color, physicsClientId=self._robot.client.id
                )
        self._plain_bodies, self._plain_robot_links = set(), set()


def _whiten(model: LoadedModel, link: int) -> None:
    bullet.changeVisualShape(model.uid, link, rgbaColor=_WHITE, physicsClientId=model.client.id)
