"""Mass, friction and mobility of shapes."""

from __future__ import annotations

import numpy as np

from rlbench_pin.compat.things.element import Element, UnsupportedCall
from rlbench_pin.compat.things.table import ObjectTable
from rlbench_pin.compat.things.thing import Thing
from rlbench_pin.robot import surfaces
from rlbench_pin.sim import Body
from rlbench_pin.urdf import read_urdf

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


def _file_mass(body: Body, index: int) -> float:
    """Mass of a link in the model file [kg]; PyBullet does not keep that of things that cannot move."""
    name = next(link for link, number in body.model.links.items() if number == index)
    inertial = next(link.inertial for link in read_urdf(body.model.urdf).links if link.name == name)
    return 0.0 if inertial is None else inertial.mass


def mass(table: ObjectTable, element: Element) -> float:
    """Return the mass of a shape [kg]."""
    body, index = body_of(table, element, "get_mass"), _index(table, element)
    kept = table.flags.get((element, "mass"))
    if isinstance(kept, float):
        return kept
    return table.world.dynamics_overrides.mass(body.model, index) or _file_mass(body, index)


def set_mass(table: ObjectTable, element: Element, kilograms: float) -> None:
    """Set the mass of a shape [kg]; that of a base that cannot move only matters once it can."""
    body, index = body_of(table, element, "set_mass"), _index(table, element)
    table.flags[element, "mass"] = kilograms
    if table.world.dynamics_overrides.mass(body.model, index) > 0.0:
        table.world.dynamics_overrides.set_mass(body.model, index, kilograms)


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
        UnsupportedCall: The body is part of the room, or a model with joints that the scene file welds to its place.
    """
    body = body_of(table, element, "set_dynamic")
    if value == (not body.fixed):
        return
    call = f"set_dynamic({value}) of '{table.name(element)}'"
    if element.kind != "body" or element.name not in table.world.spawned:
        raise UnsupportedCall(call, "the scene file says what can move.", "Set `fixed` there; one can move if it says false.")
    spec = table.world.spawned[element.name].model_copy(update={"fixed": not value})
    pose, colors, collides, graspable = body.pose, body.colors, body.collides, body.graspable
    table.world.remove_body(element.name)
    made = table.world.add_body(element.name, spec)
    made.set_pose(pose)
    made.set_colors(colors)
    made.set_collides(collides)
    made.graspable = graspable
    kept = table.flags.get((element, "mass"))
    if value and isinstance(kept, float):
        table.world.dynamics_overrides.set_mass(made.model, _BASE, kept)


def volume(thing: Thing) -> float:
    """Return the volume of the solid parts [m^3]; where they overlap it counts twice."""
    parts = [part for parts, _ in thing.solids() for part in parts]
    return float(np.sum([surfaces.part_volume(part) for part in parts]))
