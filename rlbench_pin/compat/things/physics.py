"""Mass, friction and mobility of shapes."""

from __future__ import annotations

import numpy as np

from rlbench_pin.compat.things.element import Element, UnsupportedCall
from rlbench_pin.compat.things.table import ObjectTable
from rlbench_pin.compat.things.thing import Thing
from rlbench_pin.robot import surfaces
from rlbench_pin.sim import Body

_BASE = -1


def has_body(element: Element) -> bool:
    """Whether an element is a body of the scene or the room, or a link of one."""
    return element.kind in ("body", "link", "room")


def body_of(table: ObjectTable, element: Element, call: str) -> Body:
    """Return the body that an element is, or is a link of.

    Raises:
        UnsupportedCall: It has no body.
    """
    if not has_body(element):
        raise UnsupportedCall(
            f"{call} of '{table.name(element)}'", "it is no body of the scene.", "Call it on a body, or a link of one."
        )
    return table.world.body(element.name.partition("/")[0])


def _index(table: ObjectTable, element: Element) -> int:
    body, link = body_of(table, element, "a physical property"), element.name.partition("/")[2]
    return body.model.link_index(link) if link else _BASE


def mass(table: ObjectTable, element: Element) -> float:
    """Return the mass of a shape [kg], also of one that cannot move."""
    return table.world.dynamics_overrides.mass(body_of(table, element, "get_mass").model, _index(table, element))


def set_mass(table: ObjectTable, element: Element, kilograms: float) -> None:
    """Set the mass of a shape [kg]; that of one that cannot move matters once it can."""
    model = body_of(table, element, "set_mass").model
    table.world.dynamics_overrides.set_mass(model, _index(table, element), kilograms)


def friction(table: ObjectTable, element: Element) -> float:
    """Return the coefficient of sliding friction."""
    body = body_of(table, element, "get_bullet_friction")
    return table.world.dynamics_overrides.friction(body.model, _index(table, element))


def set_friction(table: ObjectTable, element: Element, value: float) -> None:
    """Set the coefficient of sliding friction."""
    body = body_of(table, element, "set_bullet_friction")
    table.world.dynamics_overrides.set_friction(body.model, _index(table, element), value)


def set_dynamic(table: ObjectTable, element: Element, value: bool) -> None:
    """Let a body move, or hold it where it is.

    Raises:
        UnsupportedCall: It is part of the room, or a link.
        RlbenchPinError: It has joints, or no mass in its model file.
    """
    if not has_body(element) and not value:
        return
    body = body_of(table, element, "set_dynamic")
    if value == (not body.fixed):
        return
    if element.kind != "body":
        raise UnsupportedCall(
            f"set_dynamic({value}) of '{table.name(element)}'", "it is part of something larger.", "Call it on a whole body."
        )
    table.world.dynamics_overrides.set_fixed(body, not value)


def set_respondable(table: ObjectTable, element: Element, value: bool) -> None:
    """Let a body touch other things, or pass through them; planes pass through everything in any case."""
    if has_body(element) or value:
        body_of(table, element, "set_respondable").set_collides(value)


def set_obstacle(table: ObjectTable, element: Element, value: bool) -> None:
    """Let plans avoid a body, or not; other things are no obstacles."""
    if element.kind in ("body", "room"):
        table.world.body(element.name).obstacle = value


def volume(thing: Thing) -> float:
    """Return the volume of the solid parts [m^3]; where they overlap it counts twice."""
    parts = [part for parts, _ in thing.solids() for part in parts]
    return float(np.sum([surfaces.part_volume(part) for part in parts]))
