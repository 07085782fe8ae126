"""Mass, friction and mobility of shapes."""

from __future__ import annotations

import numpy as np

from rlbench_pin.compat.things.element import Element, UnsupportedCall
from rlbench_pin.compat.things.table import ObjectTable
from rlbench_pin.compat.things.thing import Thing
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.robot import geometry
from rlbench_pin.sim import Body
from rlbench_pin.spatial import FloatArray, compose, pose_at, pose_to_matrix
from rlbench_pin.urdf import UrdfOrigin, read_urdf

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


def push(table: ObjectTable, element: Element, force: FloatArray, torque: FloatArray, at: FloatArray | None = None) -> None:
    """Give a body the impulse at once that a force and a torque of one step have; what cannot move stays.

    Args:
        table: Where it is.
        element: The body.
        force: In the world (3,) [N].
        torque: In the world (3,) [N m].
        at: Where the force acts, in the world (3,) [m]; None is the centre of mass.

    Raises:
        UnsupportedCall: It is a part of something larger.
    """
    body = body_of(table, element, "a force")
    if element.kind != "body":
        raise UnsupportedCall(f"a force on '{table.name(element)}'", "it is part of something larger.", "Push a whole body.")
    if body.fixed:
        return
    T_world_com, per_kilogram = _centre_of_mass(body)
    R, kilograms = pose_to_matrix(T_world_com)[:3, :3], mass(table, element)
    turn = torque if at is None else torque + np.cross(at - T_world_com[:3], force)
    change = np.concatenate([force / kilograms, np.linalg.solve(kilograms * R @ per_kilogram @ R.T, turn)])
    body.set_velocity(body.velocity + table.world.control_dt * change)


def _centre_of_mass(body: Body) -> tuple[FloatArray, FloatArray]:
    """Return the inertial frame (7,) of the base link in the world, and the inertia (3, 3) in it over the mass [m^2]."""
    urdf, scale = read_urdf(body.model.urdf), body.model.scale
    inertial = next(link.inertial for link in urdf.links if link.name == urdf.base_link)
    if inertial is None:
        raise RlbenchPinError(f"{body.model.urdf.name} says no inertia of '{body.name}', so that no force can turn it.")
    xx, xy, xz, yy, yz, zz = inertial.inertia
    origin = inertial.origin or UrdfOrigin()
    place = compose(body.pose, pose_at([scale * x for x in origin.xyz], *origin.rpy))
    return place, np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) / inertial.mass


def volume(thing: Thing) -> float:
    """Return the volume of the solid parts [m^3]; where they overlap it counts twice."""
    parts = [part for parts, _ in thing.solids() for part in parts]
    return float(np.sum([geometry.part_volume(part) for part in parts]))
