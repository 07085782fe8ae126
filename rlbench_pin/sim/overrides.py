"""Overrides of masses, friction, damping, gains and textures, and the exact restoration of the original values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.sim.arm.control import POSITION_GAIN, SimRobot
from rlbench_pin.sim.body import BASE, Body, Color, LoadedModel, visual_colors
from rlbench_pin.sim.client import bullet
from rlbench_pin.sim.render.renderer import Renderer
from rlbench_pin.sim.render.shading import LinkTexture
from rlbench_pin.sim.render.texture import Texture
from rlbench_pin.sim.room import RoomBody
from rlbench_pin.urdf import read_urdf

_MASSLESS = {"mass": 0.0, "localInertiaDiagonal": [0.0, 0.0, 0.0]}
"""Dynamics that keep a body in place; PyBullet moves nothing that has no mass and is at rest."""


class DynamicsOverrides:
    """Masses, friction, damping and gains that differ from those of the model files.

    Args:
        robot: The arm, whose position gain can be scaled.
    """

    def __init__(self, robot: SimRobot) -> None:
        self._robot = robot
        self._originals: dict[tuple[int, int], dict[str, Any]] = {}
        self._changed: dict[tuple[int, int], dict[str, Any]] = {}
        self._held: set[int] = set()

    def scale(self, model: LoadedModel, *, mass: float = 1.0, friction: float = 1.0, damping: float = 1.0) -> None:
        """Multiply masses (with their inertia), friction coefficients and joint damping of all links of a body."""
        for link in model.links.values():
            original = self._original(model, link)
            changed = {
                "mass": original["mass"] * mass,
                "localInertiaDiagonal": [i * mass for i in original["localInertiaDiagonal"]],
                "lateralFriction": original["lateralFriction"] * friction,
            }
            if "jointDamping" in original:
                changed["jointDamping"] = original["jointDamping"] * damping
            self._change(model, link, changed)

    def mass(self, model: LoadedModel, link: int) -> float:
        """Mass of a link [kg]; for a fixed body the mass that it would have if it could move."""
        return float(self._changed.get((model.uid, link), {}).get("mass") or self._original(model, link)["mass"])

    def changed_masses(self, model: LoadedModel) -> dict[str, float]:
        """Return the masses of the links whose mass was changed [kg]."""
        changed = {name: self._changed.get((model.uid, link), {}).get("mass") for name, link in model.links.items()}
        return {name: mass for name, mass in changed.items() if mass is not None}

    def set_mass(self, model: LoadedModel, link: int, mass: float) -> None:
        """Set the mass of a link [kg]; its inertia scales with it. For a fixed body it takes effect when the body can move.

        Raises:
            RlbenchPinError: The link has no mass in its model file.
        """
        original = self._original(model, link)
        if not original["mass"] > 0.0:
            raise RlbenchPinError(f"A link of {model.urdf.name} has no mass, and so no inertia to scale. Add an <inertial>.")
        factor = mass / original["mass"]
        self._change(model, link, {"mass": mass, "localInertiaDiagonal": [i * factor for i in original["localInertiaDiagonal"]]})

    def set_fixed(self, body: Body, fixed: bool) -> None:
        """Fix a body at its pose, or let it move; its velocity becomes zero.

        Raises:
            RlbenchPinError: The body has joints, or no mass in its model file.
        """
        if fixed == body.fixed:
            return
        model = body.model
        if model.joints:
            raise RlbenchPinError(f"'{body.name}' has joints and cannot be fixed at run time. Set `fixed` in the scene file.")
        original = self._original(model, BASE)
        if not original["mass"] > 0.0:
            raise RlbenchPinError(f"'{body.name}' has no mass in {model.urdf.name}, so it cannot move. Add an <inertial>.")
        body.hold(fixed)
        if fixed:
            self._held.add(model.uid)
        else:
            self._held.discard(model.uid)
        masses = {"mass": original["mass"], "localInertiaDiagonal": original["localInertiaDiagonal"]}
        self._change(model, BASE, {**masses, **self._changed.get((model.uid, BASE), {})})

    def friction(self, model: LoadedModel, link: int) -> float:
        """Coefficient of sliding friction of a link."""
        return float(bullet.getDynamicsInfo(model.uid, link, physicsClientId=model.client.id)[1])

    def set_friction(self, model: LoadedModel, link: int, friction: float) -> None:
        """Set the coefficient of sliding friction of a link."""
        self._original(model, link)
        self._change(model, link, {"lateralFriction": friction})

    def forget(self, model: LoadedModel) -> None:
        """Drop the overrides of a removed body."""
        self._held.discard(model.uid)
        for links in (self._originals, self._changed):
            for key in [k for k in links if k[0] == model.uid]:
                del links[key]

    def scale_gains(self, factor: float) -> None:
        """Multiply the position gain of the arm's motors."""
        self._robot.position_gain = POSITION_GAIN * factor

    def clear(self) -> None:
        """Restore all original values."""
        self._robot.position_gain = POSITION_GAIN
        for (uid, link), original in self._originals.items():
            self._apply(uid, link, original)
        self._originals.clear()
        self._changed.clear()

    def apply_again(self) -> None:
        """Apply the present overrides in a physics server that was built again."""
        for (uid, link), changed in self._changed.items():
            self._apply(uid, link, changed)

    def _change(self, model: LoadedModel, link: int, changed: dict[str, Any]) -> None:
        self._changed[model.uid, link] = {**self._changed.get((model.uid, link), {}), **changed}
        self._apply(model.uid, link, self._changed[model.uid, link])

    def _apply(self, uid: int, link: int, values: dict[str, Any]) -> None:
        held = _MASSLESS if link == BASE and uid in self._held else {}
        client = self._robot.model.client
        client.changes += 1
        bullet.changeDynamics(uid, link, physicsClientId=client.id, **{**values, **held})

    def _original(self, model: LoadedModel, link: int) -> dict[str, Any]:
        key = (model.uid, link)
        if key not in self._originals:
            info = bullet.getDynamicsInfo(model.uid, link, physicsClientId=model.client.id)
            values: dict[str, Any] = {"mass": info[0], "localInertiaDiagonal": info[2], "lateralFriction": info[1]}
            if link == BASE and values["mass"] == 0.0:
                self._held.add(model.uid)
                values |= _inertial_of_file(model)
            if link >= 0:
                values["jointDamping"] = bullet.getJointInfo(model.uid, link, physicsClientId=model.client.id)[6]
            self._originals[key] = values
        return self._originals[key]


def _inertial_of_file(model: LoadedModel) -> dict[str, Any]:
    """Mass and inertia of the base link in the model file; PyBullet drops those of fixed bodies."""
    urdf = read_urdf(model.urdf)
    inertial = next(link.inertial for link in urdf.links if link.name == urdf.base_link)
    if inertial is None:
        return {"mass": 0.0, "localInertiaDiagonal": [0.0, 0.0, 0.0]}
    return {"mass": inertial.mass, "localInertiaDiagonal": [inertial.inertia[k] for k in (0, 3, 5)]}


_WHITE, _UNSEEN = (1.0, 1.0, 1.0, 1.0), (1.0, 1.0, 1.0, 0.0)


class TextureOverrides:
    """Textures over robot, bodies and room; bodies keep their own colours, which `clear` shows again.

    Args:
        renderer: The renderer of the world.
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
            texture: The image.
            repeats: How often it repeats along one metre.
        """
        self._white_robot_links.add(link)
        self._repaint_robot_link(link)
        self._renderer.set_link_texture(self._robot.uid, link, LinkTexture(texture, repeats))

    def show_robot_link(self, link: int, shown: bool) -> None:
        """Hide a link of the arm in images, or show it again; no effect on a link without visuals.

        Args:
            link: Number of the link.
            shown: Whether it is drawn from now on.
        """
        if link not in self._robot_colors:
            return
        if not shown:
            self._hidden_robot_links.add(link)
        elif link in self._hidden_robot_links:
            self._hidden_robot_links.remove(link)
        self._repaint_robot_link(link)

    def robot_link_color(self, link: int) -> Color:
        """Colour rgba in 0..1 of a link of the arm: the one that was set, or that of its first visual."""
        return self._painted_robot_links.get(link) or self._robot_colors.get(link, (_WHITE,))[0]

    def paint_robot_link(self, link: int, color: Color) -> None:
        """Set one colour rgba in 0..1 for all visuals of a link of the arm; no effect on a link without visuals."""
        if link in self._robot_colors:
            self._painted_robot_links[link] = color
            self._repaint_robot_link(link)

    def set_body(self, name: str, texture: Texture, repeats: float) -> None:
        """Put a texture on a body; if a colour was set on the body, it stays, and the texture only shades it.

        Args:
            name: Name of a body of the scene.
            texture: The image.
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

    def shade_body(self, name: str, texture: Texture, repeats: float) -> None:
        """Multiply the colours of a body by a texture; its colours do not change.

        Args:
            name: Name of a body of the scene.
            texture: The image.
            repeats: How often it repeats along one metre.
        """
        body = self._bodies[name]
        for link in body.visual_links:
            self._renderer.set_link_texture(body.model.uid, link, LinkTexture(texture, repeats))

    def set_room_body(self, name: str, texture: Texture) -> None:
        """Put a texture on table, floor, ceiling or a wall in place of its own."""
        self._room[name].texture = texture

    def shade_room_body(self, name: str, pattern: Texture | None, tint: tuple[float, float, float]) -> None:
        """Multiply the colours of table, floor, ceiling or a wall.

        Args:
            name: Name of the part of the room.
            pattern: Replaces its own texture and keeps the mean colour; None keeps the texture.
            tint: Factor of red, green and blue.
        """
        self._room[name].pattern, self._room[name].tint = pattern, tint

    def clear_body(self, name: str) -> None:
        """Restore the original appearance of one body; no effect on parts of the room."""
        if (body := self._bodies.get(name)) is None:
            return
        for link in body.visual_links:
            self._renderer.clear_link_texture(body.model.uid, link)
        if name in self._white_bodies:
            self._white_bodies.remove(name)
            body.repaint()

    def clear_room_body(self, name: str) -> None:
        """Restore the original texture of table, floor, ceiling or a wall."""
        self._room[name].texture = None

    def clear_robot_link(self, link: int) -> None:
        """Restore the original colours of one link of the arm."""
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
        """Remove all overrides and restore the original colours and textures."""
        self._renderer.clear_link_textures()
        for body in self._room.values():
            body.texture, body.pattern, body.tint = None, None, (1.0, 1.0, 1.0)
        for name in self._white_bodies & set(self._bodies):
            self._bodies[name].repaint()
        links, self._white_bodies, self._white_robot_links = self._white_robot_links, set(), set()
        for link in links:
            self._repaint_robot_link(link)


def _whiten(model: LoadedModel, link: int) -> None:
    bullet.changeVisualShape(model.uid, link, rgbaColor=_WHITE, physicsClientId=model.client.id)
