"""What is selected, as numbers and choices."""

from __future__ import annotations

from collections.abc import Callable

from rlbench_pin.builder.document import HasDependants
from rlbench_pin.builder.view.panels.bodies import body_items
from rlbench_pin.builder.view.panels.placement import placement_items
from rlbench_pin.builder.view.panels.volumes import region_items, sensor_items
from rlbench_pin.builder.view.panels.waypoints import overview_item, waypoint_items
from rlbench_pin.builder.view.posing import pose_of, position_of, turn_of
from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.snapping import SNAPS
from rlbench_pin.builder.view.widgets import Button, Check, Choice, Entry, Item, Note, Row, Vector
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.scene import BodySpec, RegionSpec, SceneSpec, SensorSpec, WaypointSpec, resolve_asset
from rlbench_pin.scene.spec import ROOT, WORLD, PosedSpec
from rlbench_pin.spatial import FloatArray, compose, inverse
from rlbench_pin.urdf import read_urdf

_DROP = "Let go over a body, a thing that is dragged hangs on it: the body in the yellow box. It stays where it was let go."


def property_items(session: Session, snap_now: Callable[[], None]) -> list[Item]:
    """Return what can be said of the selected thing.

    Args:
        session: What is being edited.
        snap_now: Puts the selected thing where it would fall after a drag.
    """
    name = session.selected
    thing = session.thing(name)
    if name == ROOT:
        return [Note("### root"), *placement_items(session)]
    if thing is None:
        hint = "Click on a thing in the scene or in the tree to change it. *Add* has what can be added."
        return [Note(hint), overview_item(session)]
    items: list[Item] = [Note(f"### {name}"), *_name_items(session, name), *_place_items(session, thing, snap_now)]
    if isinstance(thing, BodySpec):
        items += body_items(session, thing)
    elif isinstance(thing, RegionSpec):
        items += region_items(session, thing)
    elif isinstance(thing, SensorSpec):
        items += sensor_items(session, thing)
    elif isinstance(thing, WaypointSpec):
        items += [*waypoint_items(session, thing), overview_item(session)]
    return items


def _name_items(session: Session, name: str) -> list[Item]:
    items: list[Item] = []
    if session.table_of(name) != "waypoint":  # their names are their order
        items.append(Entry("Name", name, lambda text: _rename(session, name, text.strip()), "Rename"))

    def duplicate() -> None:
        made: list[str] = []
        session.do(lambda document: made.append(document.duplicate(name)))
        if made:
            session.select(made[0])

    items.append(Row(session.table_of(name).capitalize(), {"Duplicate": duplicate, "Delete": lambda: _delete(session, name)}))
    if session.needed is not None and session.needed.name == name:
        items += _needed_items(session, session.needed)
    return items


def _delete(session: Session, name: str) -> None:
    """Delete a thing; where others need it, ask first."""
    try:
        session.document.delete(name)
    except HasDependants as error:
        session.needed = error
    session.select(session.selected)


def _needed_items(session: Session, needed: HasDependants) -> list[Item]:
    """Return what would go with a thing, and the question whether it may."""
    lines = [
        f"Nothing was deleted yet. With `{needed.name}` would go:",
        *(f"- `{name}`, which hangs on it" for name in needed.dependants),
    ]
    if needed.mentions:
        lines.append(
            "- conditions, grasps and random places that name it; other lines of Python stay and have to be changed by hand:"
        )
        lines += [f"    - `{line}`" for line in needed.mentions]

    def delete() -> None:
        session.do(lambda document: document.delete(needed.name, with_dependants=True))

    def keep() -> None:
        session.needed = None
        session.changed()

    return [Note("\n".join(lines)), Button("Delete with what hangs on it", delete, "red"), Button("Keep it", keep)]


def _rename(session: Session, old: str, new: str) -> None:
    left: list[str] = []
    step = session.document.step
    session.do(lambda document: left.extend(document.rename(old, new)))
    if session.document.step == step:
        return
    session.select(new)
    if left:
        lines = "\n".join(f"line {line}" for line in left)
        session.tell("Renamed", f"The Python still says '{old}' in a way that was left:\n{lines}", bad=True)


def _place_items(session: Session, thing: PosedSpec, snap_now: Callable[[], None]) -> list[Item]:
    pose, name = thing.pose, thing.name

    def put(new: FloatArray) -> None:
        session.do(lambda document: document.set(name, "pose", tuple(new.tolist()), merge=f"pose of {name}"))

    def attach(parent: str) -> None:
        places = session.places
        frame, here = places.of(parent), places.of(name)
        if frame is None or here is None:
            return
        session.do(lambda document: document.attach(name, parent, compose(inverse(frame), here)))

    return [
        Choice("Parent", thing.parent, parents_of(session.spec, thing), attach, hint="With what it moves; it stays where it is"),
        Check("Drop onto", session.drops_onto, lambda value: _set_drop(session, value), hint=_DROP),
        Vector("x y z [m]", position_of(pose), lambda value: put(pose_of(value, turn_of(pose))), 0.01),
        Vector("roll pitch yaw [deg]", turn_of(pose), lambda value: put(pose_of(position_of(pose), value)), 15.0),
        Choice("Snap to", session.snap, tuple(SNAPS), lambda value: _set_snap(session, value)),
        Button("Snap now", snap_now),
    ]


def _set_drop(session: Session, value: bool) -> None:
    session.drops_onto = value
    session.changed()


def _set_snap(session: Session, value: str) -> None:
    session.snap = next(snap for snap in SNAPS if snap == value)
    session.changed()


def parents_of(spec: SceneSpec, thing: PosedSpec) -> tuple[str, ...]:
    """Return what a thing may hang on: all but itself and what hangs on it."""
    below = {thing.name}
    grown = True
    while grown:
        more = {t.name for t in spec.posed() if t.parent.partition("/")[0] in below}
        grown = not more <= below
        below |= more
    names = [ROOT, WORLD]
    for other in spec.posed():
        if other.name not in below:
            names.append(other.name)
            names += [f"{other.name}/{link}" for link in _links(spec, other)]
    return tuple(dict.fromkeys([*names, thing.parent]))


def _links(spec: SceneSpec, thing: PosedSpec) -> tuple[str, ...]:
    """Return the links of a body that has several."""
    if not isinstance(thing, BodySpec):
        return ()
    try:
        links = read_urdf(resolve_asset(spec, thing.asset)).link_names
    except RlbenchPinError:
        return ()
    return links if len(links) > 1 else ()


__all__ = ["parents_of", "property_items"]
