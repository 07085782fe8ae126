"""The tab *Selected*: name, parent and pose of the selected element, and the values of its kind."""

from __future__ import annotations

import math
from collections.abc import Callable

from rlbench_pin.builder.document import HasDependants, TaskDocument
from rlbench_pin.builder.view.placing import SNAPS, Vector3, angles_of, pose_of, position_of
from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.waypoints import show_overview, show_waypoint
from rlbench_pin.builder.view.widgets import Panel
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.scene import BodySpec, JointSpec, RegionSpec, SceneSpec, SensorSpec, WaypointSpec, resolve_asset
from rlbench_pin.scene.spec import ROOT, WORLD, PosedSpec
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray, compose, inverse
from rlbench_pin.tasks import COLORS
from rlbench_pin.urdf import UrdfJoint, read_urdf

SHAPES = ("box", "cylinder", "sphere")
"""Shapes of sensors."""
_DROP_HINT = "Drop an element over a body to attach it. A yellow box marks the body. The element keeps its pose in the world."
_FILE_COLOR, _OTHER_COLOR = "as in its file", "another"
_MOVABLE = ("revolute", "continuous", "prismatic")
_HALF_TURN, _MIN_SIZE = 3.1416, 0.001


def show_properties(panel: Panel, session: Session, snap_now: Callable[[], None]) -> None:
    """Show the values of the selected element.

    Args:
        panel: The tab.
        session: The edited task.
        snap_now: Snaps the selected element.
    """
    name = session.selected
    element = session.element(name)
    if name == ROOT:
        panel.note("### root")
        _show_placement(panel, session)
        return
    if element is None:
        panel.note("Click an element in the scene or in the tree to change it. *Add* creates elements.")
        show_overview(panel, session)
        return
    panel.note(f"### {name}")
    _show_name(panel, session, name)
    _show_pose(panel, session, element, snap_now)
    if isinstance(element, BodySpec):
        _show_body(panel, session, element)
    elif isinstance(element, RegionSpec):
        _show_region(panel, session, element)
    elif isinstance(element, SensorSpec):
        _show_sensor(panel, session, element)
    elif isinstance(element, WaypointSpec):
        show_waypoint(panel, session, element)
        show_overview(panel, session)


# Name and deletion ---------------------------------------------------------------------------------------------------


def _show_name(panel: Panel, session: Session, name: str) -> None:
    def delete() -> None:
        """Delete the element; ask first if other elements depend on it."""
        try:
            session.document.delete(name)
        except HasDependants as error:
            session.pending_deletion = error
        session.select(session.selected)

    def duplicate() -> None:
        session.do_and_select(lambda document: document.duplicate(name))

    table = session.table_of(name)
    if table != "waypoint":  # names of waypoints are their order
        panel.entry("Name", name, lambda text: _rename(session, name, text.strip()), "Rename")
    panel.button_row(table.capitalize(), {"Duplicate": duplicate, "Delete": delete})
    if session.pending_deletion is not None and session.pending_deletion.name == name:
        _show_confirmation(panel, session, session.pending_deletion)


def _show_confirmation(panel: Panel, session: Session, needed: HasDependants) -> None:
    """Show what would be deleted with an element, and ask."""
    lines = [f"Nothing was deleted yet. With `{needed.name}`, these would be deleted:"]
    lines += [f"- `{name}`, which is attached to it" for name in needed.dependants]
    if needed.mentions:
        lines.append("- conditions, grasps and random places that name it; change other lines of Python by hand:")
        lines += [f"    - `{line}`" for line in needed.mentions]

    def keep() -> None:
        session.pending_deletion = None
        session.changed()

    def delete() -> None:
        session.do(lambda document: document.delete(needed.name, with_dependants=True))

    panel.note("\n".join(lines))
    panel.button("Delete with all dependants", delete, "red")
    panel.button("Keep it", keep)


def _rename(session: Session, old: str, new: str) -> None:
    left: list[str] = []

    def rename(document: TaskDocument) -> str:
        left.extend(document.rename(old, new))
        return new

    session.do_and_select(rename)
    if left:
        lines = "\n".join(f"line {line}" for line in left)
        session.show_message("Renamed", f"The Python still names '{old}' in lines that were not changed:\n{lines}", bad=True)


# Parent and pose -----------------------------------------------------------------------------------------------------


def _show_pose(panel: Panel, session: Session, element: PosedSpec, snap_now: Callable[[], None]) -> None:
    pose, name = element.pose, element.name

    def put(new: FloatArray) -> None:
        session.do(lambda document: document.set(name, "pose", tuple(new.tolist()), merge=f"pose of {name}"))

    def attach(parent: str) -> None:
        frame, present = session.places.of(parent), session.places.of(name)
        if frame is not None and present is not None:
            session.do(lambda document: document.attach(name, parent, compose(inverse(frame), present)))

    def set_drop(value: bool) -> None:
        session.drops_onto = value
        session.changed()

    def set_snap(value: str) -> None:
        session.snap = next(snap for snap in SNAPS if snap == value)
        session.changed()

    parents = possible_parents(session.spec, element)
    panel.dropdown("Parent", element.parent, parents, attach, "The element moves with it, and keeps its pose in the world")
    panel.checkbox("Drop onto", session.drops_onto, set_drop, _DROP_HINT)
    panel.vector("x y z [m]", position_of(pose), lambda value: put(pose_of(value, angles_of(pose))), 0.01)
    panel.vector("roll pitch yaw [deg]", angles_of(pose), lambda value: put(pose_of(position_of(pose), value)), 15.0)
    panel.dropdown("Snap to", session.snap, SNAPS, set_snap)
    panel.button("Snap now", snap_now)


def possible_parents(spec: SceneSpec, element: PosedSpec) -> tuple[str, ...]:
    """Return all names that an element may be attached to: not itself, nor what is attached to it."""
    below = {element.name}
    grown = True
    while grown:
        more = {e.name for e in spec.posed() if e.parent.partition("/")[0] in below}
        grown = not more <= below
        below |= more
    names = [ROOT, WORLD]
    for other in spec.posed():
        if other.name not in below:
            names.append(other.name)
            names += [f"{other.name}/{link}" for link in _links(spec, other)]
    return tuple(dict.fromkeys([*names, element.parent]))


def _links(spec: SceneSpec, element: PosedSpec) -> tuple[str, ...]:
    """Return the links of a body with more than one."""
    if not isinstance(element, BodySpec):
        return ()
    try:
        links = read_urdf(resolve_asset(spec, element.asset)).link_names
    except RlbenchPinError:
        return ()
    return links if len(links) > 1 else ()


# The placement of the task -------------------------------------------------------------------------------------------


def _show_placement(panel: Panel, session: Session) -> None:
    """Show the nominal pose of the root, and the bounds of random ones."""
    placement = session.spec.placement
    x, y, z = position_of(placement.pose)
    low, high = placement.yaw

    def change(key: str, value: object) -> None:
        session.do(lambda document: document.set_placement(key, value))

    def move(value: Vector3) -> None:
        pose = pose_of((value[0], value[1], value[2] + TABLE_HEIGHT), angles_of(placement.pose))
        change("pose", tuple(pose.tolist()))

    def rotate(degrees: float) -> None:
        change("pose", tuple(pose_of((x, y, z), (0.0, 0.0, degrees)).tolist()))

    def radians(degrees: float) -> float:
        return round(math.radians(degrees), 4)

    def set_patch(number: int, value: float) -> None:
        sides = [footprint[0] or 0.3, footprint[1] or 0.3]
        sides[number] = round(value, 4)
        change("footprint", tuple(sides) if all(side > 0.0 for side in sides) else None)

    panel.note("The pose of the task on the table. Elements without another parent are attached to it.")
    panel.vector("x y [m], height above the table", (x, y, round(z - TABLE_HEIGHT, 4)), move, 0.01)
    panel.number("Yaw [deg]", angles_of(placement.pose)[2], rotate, 15.0, -180.0, 180.0)
    panel.checkbox("Same place in every episode", placement.static, lambda value: change("static", value))
    if placement.static:
        return
    low_degrees, high_degrees = (round(math.degrees(angle), 2) for angle in (low, high))
    footprint = placement.footprint or (0.0, 0.0)
    panel.number("Smallest random yaw [deg]", low_degrees, lambda v: change("yaw", (radians(v), high)), 5.0, -360.0, 360.0)
    panel.number("Largest random yaw [deg]", high_degrees, lambda v: change("yaw", (low, radians(v))), 5.0, -360.0, 360.0)
    panel.number("Patch x [m], 0: box around all bodies", footprint[0], lambda value: set_patch(0, value), 0.05, 0.0)
    panel.number("Patch y [m]", footprint[1], lambda value: set_patch(1, value), 0.05, 0.0)


# Bodies --------------------------------------------------------------------------------------------------------------


def _show_body(panel: Panel, session: Session, body: BodySpec) -> None:
    name = body.name

    def change(key: str, value: object) -> None:
        session.do(lambda document: document.set(name, key, value, merge=f"{key} of {name}"))

    def set_color(word: str) -> None:
        if word != _OTHER_COLOR:
            session.do(lambda document: document.set(name, "color", palette.get(word)))

    panel.note(f"`{body.asset}`")
    panel.checkbox("Fixed", body.fixed, lambda value: change("fixed", value), "Cannot move; otherwise it falls")
    panel.checkbox("Collides", body.collides, lambda value: change("collides", value), "Off for visual markers")
    palette = {color.name: color.rgb for color in COLORS}
    color = _FILE_COLOR
    if body.color is not None:
        color = next((word for word, rgb in palette.items() if rgb == tuple(body.color[:3])), _OTHER_COLOR)
    options = (_FILE_COLOR, *palette, *([_OTHER_COLOR] if color == _OTHER_COLOR else []))
    panel.dropdown("Colour", color, options, set_color, "The palette of the variations")
    panel.number("Scale", body.scale, lambda value: change("scale", round(value, 4)), 0.05, 0.0001, 100.0)
    try:
        joints = [j for j in read_urdf(resolve_asset(session.spec, body.asset)).joints if j.kind in _MOVABLE]
    except RlbenchPinError as error:
        panel.note(str(error))
        return
    for joint in joints:
        _show_joint(panel, session, body, joint)


def _show_joint(panel: Panel, session: Session, body: BodySpec, joint: UrdfJoint) -> None:
    name = f"{body.name}/{joint.name}"
    spec = next((j for j in session.spec.joint if j.name == name), JointSpec(name=name))
    bounds = zip(joint.limits, (-_HALF_TURN, _HALF_TURN), strict=True)
    low, high = (round(limit, 4) if abs(limit) < 1e3 else default for limit, default in bounds)
    unit = "m" if joint.kind == "prismatic" else "rad"

    def change(key: str, value: object) -> None:
        session.do(lambda document: document.set(name, key, value, merge=f"{key} of {name}"))

    def slide(value: float) -> None:
        change("position", min(max(round(value, 4), joint.limits[0]), joint.limits[1]))

    with panel.folder(joint.name) as folder:
        folder.slider(f"Starts at [{unit}]", round(spec.position, 4), slide, low, max(high, low + 0.001))
        folder.number("Friction", spec.friction, lambda value: change("friction", round(value, 4)), 0.01, 0.0)
        folder.checkbox("Locked", spec.locked, lambda value: change("locked", value), "Locked until the task unlocks it")


# Regions and sensors -------------------------------------------------------------------------------------------------


def _show_region(panel: Panel, session: Session, region: RegionSpec) -> None:
    size = region.size

    def change(value: Vector3) -> None:
        x, y, z = (round(abs(v), 4) for v in value)
        new = max(x, _MIN_SIZE), max(y, _MIN_SIZE), z
        session.do(lambda document: document.set(region.name, "size", new, merge=f"size of {region.name}"))

    panel.vector("Size x y z [m]", (size[0], size[1], size[2]), change, hint="Flat if its height is 0")


def _show_sensor(panel: Panel, session: Session, sensor: SensorSpec) -> None:
    name, size = sensor.name, sensor.size

    def resize(number: int, value: float) -> None:
        new = tuple(round(max(abs(value), _MIN_SIZE), 4) if k == number else v for k, v in enumerate(size))
        session.do(lambda document: document.set(name, "size", new, merge=f"size of {name}"))

    def reshape(shape: str) -> None:
        x, z = size[0], size[-1]
        new = {"box": (x, size[1] if len(size) == 3 else x, z), "cylinder": (x, z), "sphere": (x,)}[shape]
        session.do(lambda document: document.set_several(name, {"shape": shape, "size": new}))

    panel.dropdown("Shape", sensor.shape, SHAPES, reshape)
    words = {"box": ("x", "y", "z"), "cylinder": ("Diameter", "Length"), "sphere": ("Diameter",)}[sensor.shape]
    for number, word in enumerate(words):
        panel.number(f"{word} [m]", size[number], lambda value, k=number: resize(k, value), 0.01, _MIN_SIZE)  # type: ignore[misc]
