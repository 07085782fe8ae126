"""What is selected, as numbers and choices."""

from __future__ import annotations

from collections.abc import Callable

from rlbench_pin.builder.view.panels.bodies import body_items
from rlbench_pin.builder.view.panels.placement import placement_items
from rlbench_pin.builder.view.panels.volumes import region_items, sensor_items
from rlbench_pin.builder.view.panels.waypoints import overview_item, waypoint_items
from rlbench_pin.builder.view.posing import pose_of, position_of, turn_of
from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.snapping import SNAPS
from rlbench_pin.builder.view.widgets import Button, Choice, Entry, Item, Note, Vector
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.scene import BodySpec, RegionSpec, SceneSpec, SensorSpec, WaypointSpec, resolve_asset
from rlbench_pin.scene.spec import ROOT, WORLD, PosedSpec
from rlbench_pin.spatial import FloatArray, compose, inverse
from rlbench_pin.urdf import read_urdf


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

    def delete(everything: bool) -> Callable[[], None]:
        return lambda: session.do(lambda document: document.delete(name, with_dependants=everything))

    items.append(Button("Duplicate", duplicate))
    items.append(Button("Delete", delete(False), "red"))
    dependants = [t.name for t in session.spec.posed() if t.parent.partition("/")[0] == name]
    if dependants:
        items.append(Button("Delete with what hangs on it", delete(True), "red", hint=", ".join(dependants)))
    return items


def _rename(session: Session, old: str, new: str) -> None:
    session.do(lambda document: document.rename(old, new))
    if session.thing(new) is not None:
        session.select(new)


def _place_items(session: Session, thing: PosedSpec, snap_now: Callable[[], None]) -> list[Item]:
    pose, name = thing.pose, thing.name

    def put(new: FloatArray) -> None:
        session.do(lambda document: document.set(name, "pose", tuple(new.tolist()), merge=f"pose of {name}"))

    def attach(parent: str) -> None:
        places = session.places
        frame, here = places.of(parent), places.of(name)
        if frame is None or here is None:
            return
        local = compose(inverse(frame), here)
        session.do(lambda document: document.set(name, "parent", parent))
        put(pose_of(position_of(local), turn_of(local)))

    return [
        Choice("Parent", thing.parent, parents_of(session.spec, thing), attach, hint="With what it moves; it stays where it is"),
        Vector("x y z [m]", position_of(pose), lambda value: put(pose_of(value, turn_of(pose))), 0.01),
        Vector("roll pitch yaw [deg]", turn_of(pose), lambda value: put(pose_of(position_of(pose), value)), 15.0),
        Choice("Snap to", session.snap, tuple(SNAPS), lambda value: _set_snap(session, value)),
        Button("Snap now", snap_now),
    ]


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
