"""Colours and textures of things."""

from __future__ import annotations

from rlbench_pin.compat.things.element import Element
from rlbench_pin.compat.things.table import ObjectTable
from rlbench_pin.sim import Texture
from rlbench_pin.urdf import read_urdf

Rgba = tuple[float, ...]
_ROBOT = ("robot", "gripper", "robot_link")


def color(table: ObjectTable, element: Element) -> Rgba:
    """Return the colour rgba of a shape; planes, which are not drawn, have the one that they were given."""
    world, (owner, _, link) = table.world, element.name.partition("/")
    if element.kind in ("body", "room"):
        return world.body(element.name).color
    if element.kind == "link":
        body = world.body(owner)
        return body.colors.get(body.model.link_index(link), _file_color(table, owner, link))
    if element.kind in _ROBOT:
        return world.texture_overrides.robot_link_color(_robot_links(table, element)[0])
    given = table.flags.get((element, "color"), (1.0, 1.0, 1.0, 1.0))
    assert isinstance(given, tuple)
    return given


def _robot_links(table: ObjectTable, element: Element) -> list[int]:
    """Numbers of the links of the arm that an element stands for, those with visuals first."""
    model, description = table.world.robot.model, table.runtime.description
    hand = (description.hand_link, *description.finger_links)
    names = {"robot": tuple(model.links), "gripper": hand}.get(element.kind, (element.name,))
    seen = table.world.texture_overrides.robot_links
    return sorted((model.link_index(name) for name in names), key=lambda index: index not in seen)


def _file_color(table: ObjectTable, body: str, link: str) -> Rgba:
    """Colour of the first visual of a link in its model file."""
    found = next(part for part in read_urdf(table.world.body(body).model.urdf).links if part.name == link)
    colors = [visual.color for visual in found.visuals if visual.color is not None]
    return colors[0] if colors else (1.0, 1.0, 1.0, 1.0)


def paint(table: ObjectTable, element: Element, rgba: Rgba) -> None:
    """Colour a shape; of planes, which are not drawn, the colour is only kept."""
    world, (owner, _, link) = table.world, element.name.partition("/")
    if element.kind in ("body", "room"):
        world.body(element.name).set_color(rgba)
    elif element.kind == "link":
        world.body(owner).set_color(rgba, link)
    elif element.kind in _ROBOT:
        red, green, blue, alpha = rgba
        for index in _robot_links(table, element):
            world.texture_overrides.paint_robot_link(index, (red, green, blue, alpha))
    else:
        table.flags[element, "color"] = tuple(rgba)


def show(table: ObjectTable, element: Element, shown: bool) -> None:
    """Show a shape to cameras, or hide it; its colour comes back with it."""
    if element.kind in _ROBOT:
        for index in _robot_links(table, element):
            table.world.texture_overrides.show_robot_link(index, shown)
        return
    rgba = color(table, element)
    if not shown:
        table.flags[element, "opacity"] = rgba[3]
    opacity = table.flags.get((element, "opacity"), 1.0)
    assert isinstance(opacity, float)
    paint(table, element, (*rgba[:3], opacity if shown else 0.0))


def set_texture(table: ObjectTable, element: Element, texture: Texture, repeats: float) -> None:
    """Put a texture on a shape; planes are not drawn, and stay as they are.

    Args:
        table: Things of the world.
        element: A body, a part of the room, or a link of the arm.
        texture: The picture.
        repeats: How often it repeats along one metre.
    """
    overrides = table.world.texture_overrides
    match element.kind:
        case "body":
            overrides.set_body(element.name, texture, repeats)
        case "link":
            overrides.set_body(element.name.partition("/")[0], texture, repeats)
        case "room":
            overrides.set_room_body(element.name, texture)
        case "robot" | "gripper" | "robot_link":
            for index in set(_robot_links(table, element)) & set(overrides.robot_links):
                overrides.set_robot_link(index, texture, repeats)


def remove_texture(table: ObjectTable, element: Element) -> None:
    """Show the own look of a shape again."""
    overrides = table.world.texture_overrides
    if element.kind == "room":
        overrides.clear_room_body(element.name)
    elif element.kind in ("body", "link"):
        overrides.clear_body(element.name.partition("/")[0])
    elif element.kind in _ROBOT:
        for index in _robot_links(table, element):
            overrides.clear_robot_link(index)
