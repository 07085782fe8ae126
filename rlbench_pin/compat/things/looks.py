"""Colours and textures of things."""

from __future__ import annotations

from rlbench_pin.compat.things.element import Element, UnsupportedCall
from rlbench_pin.compat.things.table import ObjectTable
from rlbench_pin.sim import Texture
from rlbench_pin.urdf import read_urdf

Rgba = tuple[float, ...]


def color(table: ObjectTable, element: Element) -> Rgba:
    """Return the colour rgba of a shape; planes are white."""
    world, (owner, _, link) = table.world, element.name.partition("/")
    if element.kind in ("body", "room"):
        return world.body(element.name).color
    if element.kind == "link":
        body = world.body(owner)
        return body.colors.get(body.model.link_index(link), _file_color(table, owner, link))
    return (1.0, 1.0, 1.0, 1.0)


def _file_color(table: ObjectTable, body: str, link: str) -> Rgba:
    """Colour of the first visual of a link in its model file."""
    found = next(part for part in read_urdf(table.world.body(body).model.urdf).links if part.name == link)
    colors = [visual.color for visual in found.visuals if visual.color is not None]
    return colors[0] if colors else (1.0, 1.0, 1.0, 1.0)


def paint(table: ObjectTable, element: Element, rgba: Rgba) -> None:
    """Colour a shape.

    Raises:
        UnsupportedCall: It belongs to the arm.
    """
    world, (owner, _, link) = table.world, element.name.partition("/")
    if element.kind in ("body", "room"):
        world.body(element.name).set_color(rgba)
    elif element.kind == "link":
        world.body(owner).set_color(rgba, link)
    elif element.kind in ("robot", "robot_link", "gripper"):
        raise UnsupportedCall(
            f"colouring '{table.name(element)}'", "the arm's colours are fixed.", "Put a texture on it with `set_texture`."
        )


def show(table: ObjectTable, element: Element, shown: bool) -> None:
    """Show a shape to cameras, or hide it; its colour comes back with it."""
    if element.kind in ("robot", "gripper", "robot_link"):
        _show_robot(table, element, shown)
        return
    rgba = color(table, element)
    if not shown:
        table.flags[element, "opacity"] = rgba[3]
    opacity = table.flags.get((element, "opacity"), 1.0)
    assert isinstance(opacity, float)
    paint(table, element, (*rgba[:3], opacity if shown else 0.0))


def _show_robot(table: ObjectTable, element: Element, shown: bool) -> None:
    model, description = table.world.robot.model, table.runtime.description
    hand = (description.hand_link, *description.finger_links)
    links = {"robot": tuple(model.links), "gripper": hand}.get(element.kind, (element.name,))
    for link in links:
        table.world.texture_overrides.show_robot_link(model.link_index(link), shown)


def set_texture(table: ObjectTable, element: Element, texture: Texture, repeats: float) -> None:
    """Put a texture on a shape.

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
        case "robot_link":
            index = table.world.robot.model.link_index(element.name)
            if index in overrides.robot_links:
                overrides.set_robot_link(index, texture, repeats)
        case "robot":
            for index in overrides.robot_links:
                overrides.set_robot_link(index, texture, repeats)
        case _:
            raise UnsupportedCall(
                f"set_texture of '{table.name(element)}'", "planes are not drawn.", "Put the texture on a body of the scene."
            )


def remove_texture(table: ObjectTable, element: Element) -> None:
    """Show the own look of a shape again."""
    overrides = table.world.texture_overrides
    if element.kind == "room":
        overrides.clear_room_body(element.name)
    elif element.kind in ("body", "link"):
        overrides.clear_body(element.name.partition("/")[0])
    elif element.kind in ("robot", "robot_link"):
        links = overrides.robot_links
        if element.kind == "robot_link":
            links = (table.world.robot.model.link_index(element.name),)
        for link in links:
            overrides.clear_robot_link(link)
