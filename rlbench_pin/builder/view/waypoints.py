"""Waypoints in the tab *Selected*: reachability, path, gripper, curve, the order of visits."""

from __future__ import annotations

import math

from rlbench_pin.builder.view.placing import Vector3, angles_of, pose_of, position_of
from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.widgets import Color, Panel, Sign
from rlbench_pin.scene import WaypointSpec
from rlbench_pin.scene.spec import ArcSpec
from rlbench_pin.spatial import IDENTITY, FloatArray

PATHS = ("plan", "straight", "curve")
"""Paths to a waypoint."""
GRIPPER = ("leave", "open", "close", "amount")
"""Gripper actions at a waypoint."""
VERDICT_COLORS: dict[str, Color] = {"free": "green", "collides": "orange", "unreachable": "red"}
_SIGNS: dict[str, Sign] = {"free": "good", "collides": "doubtful", "unreachable": "bad"}
_CURVES = ("sweep", "poses to pass")
_QUARTER_TURN: dict[str, object] = {"axis": (0.0, 0.0, 1.0), "angle": 1.5708}
_FIRST_POSE = (0.0, 0.0, -0.05, 0.0, 0.0, 0.0, 1.0)
_POSE_STEP = 0.02


def show_waypoint(panel: Panel, session: Session, waypoint: WaypointSpec) -> None:
    """Show the reachability and the values of a waypoint."""
    name, amount = waypoint.name, waypoint.gripper

    def change(key: str, value: object) -> None:
        session.do(lambda document: document.set(name, key, value, merge=f"{key} of {name}"))

    def set_path(path: str) -> None:
        values: dict[str, object] = {"path": path}
        if path == "curve" and waypoint.arc is None and not waypoint.points:
            values["arc"] = _QUARTER_TURN
        if path != "curve":
            values |= {"arc": None, "points": None}
        session.do(lambda document: document.set_several(name, values))

    def set_gripper(word: str) -> None:
        change("gripper", {"leave": None, "amount": 0.5}.get(word, word))

    verdict = session.status.verdicts.get(name)
    if verdict is None:
        panel.sign("unknown", session.status.fault or "Not computed yet.")
    else:
        panel.sign(_SIGNS[verdict.standing], verdict.cause or "The gripper reaches it.")
    _show_order(panel, session, waypoint)
    panel.dropdown("Path", waypoint.path, PATHS, set_path, "Path to the waypoint")
    if waypoint.path == "curve":
        _show_curve(panel, session, waypoint)
    ignore = waypoint.ignore_collisions
    panel.checkbox("Ignore collisions", ignore, lambda value: change("ignore_collisions", value), "For contact")
    if waypoint.path != "curve":
        hint = "A slow straight line that yields at contact, for insertion"
        panel.checkbox("Compliant", waypoint.compliant, lambda value: change("compliant", value), hint)
    word = "leave" if amount is None else amount if isinstance(amount, str) else "amount"
    panel.dropdown("Gripper", word, GRIPPER, set_gripper, "After arriving")
    if amount is not None and not isinstance(amount, str):
        panel.number("Opening, 0 closed to 1", amount, lambda value: change("gripper", round(value, 3)), 0.05, 0.0, 1.0)
    hint = "The gripper may arrive rotated about its z axis by any multiple of 360 degrees divided by this number"
    symmetry = waypoint.symmetry
    panel.number("Symmetry", symmetry, lambda v: change("symmetry", min(max(round(v), 1), 12)), 1.0, 1.0, 12.0, hint)


# Order of visits -----------------------------------------------------------------------------------------------------


def in_order(session: Session) -> list[WaypointSpec]:
    """Return the waypoints by their numbers."""
    return sorted(session.spec.waypoint, key=lambda waypoint: _number(waypoint.name))


def _number(name: str) -> int:
    digits = name.removeprefix("waypoint")
    return int(digits) if digits.isdecimal() else 0


def show_overview(panel: Panel, session: Session) -> None:
    """Show all waypoints in the order of visits, and why some are not reached."""
    with panel.folder("Waypoints in the order of visits") as folder:
        for waypoint in in_order(session):
            name, verdict = waypoint.name, session.status.verdicts.get(waypoint.name)
            color: Color = "gray" if verdict is None else VERDICT_COLORS[verdict.standing]
            color = "blue" if name == session.selected else color
            folder.button(_summary(waypoint), lambda name=name: session.select(name), color, key=f"visit {name}")  # type: ignore[misc]
            if verdict is not None and verdict.standing != "free":
                folder.sign(_SIGNS[verdict.standing], verdict.cause)
        if not session.spec.waypoint:
            folder.note("None yet: see *Add*. They are visited in the order of their numbers.")


def _summary(waypoint: WaypointSpec) -> str:
    amount = waypoint.gripper
    gripper = amount if isinstance(amount, str) else f"gripper to {amount:g}" if amount is not None else ""
    extras = (
        waypoint.path if waypoint.path != "plan" else "",
        "ignores collisions" if waypoint.ignore_collisions else "",
        "compliant" if waypoint.compliant else "",
        gripper,
        f"symmetry {waypoint.symmetry}" if waypoint.symmetry > 1 else "",
    )
    text = ", ".join(word for word in extras if word)
    return f"{_number(waypoint.name)} on {waypoint.parent}{f': {text}' if text else ''}"


def _show_order(panel: Panel, session: Session, waypoint: WaypointSpec) -> None:
    name, names = waypoint.name, tuple(w.name for w in in_order(session))
    number = names.index(name)

    def move(index: int) -> None:
        if 0 <= index < len(names) and index != number:
            session.do_and_select(lambda document: document.move_waypoint(name, index))

    def insert() -> None:
        values = {"parent": waypoint.parent, "pose": waypoint.pose}
        session.do_and_select(lambda document: document.insert_waypoint(_number(name), values))

    panel.dropdown("Visited as", name, names, lambda value: move(names.index(value)), "The others move up")
    presses = {"Earlier": lambda: move(number - 1), "Later": lambda: move(number + 1), "Insert before": insert}
    panel.button_row("Order", presses)


# Curves --------------------------------------------------------------------------------------------------------------


def _show_curve(panel: Panel, session: Session, waypoint: WaypointSpec) -> None:
    kind = _CURVES[0] if waypoint.arc is not None else _CURVES[1]

    def choose(word: str) -> None:
        poses = (_FIRST_POSE, tuple(IDENTITY))
        values = {"arc": _QUARTER_TURN, "points": None} if word == _CURVES[0] else {"arc": None, "points": poses}
        if word != kind:
            session.do(lambda document: document.set_several(waypoint.name, values))

    hint = "A part of a circle, or a sequence of poses in the waypoint's frame"
    panel.dropdown("Curve", kind, _CURVES, choose, hint)
    if waypoint.arc is not None:
        _show_sweep(panel, session, waypoint, waypoint.arc)
    else:
        _show_poses(panel, session, waypoint)


def _show_sweep(panel: Panel, session: Session, waypoint: WaypointSpec, arc: ArcSpec) -> None:
    def change(**values: object) -> None:
        new = arc.model_copy(update=values).model_dump(exclude_defaults=True)
        session.do(lambda document: document.set(waypoint.name, "arc", new, merge=f"arc of {waypoint.name}"))

    def set_axis(axis: Vector3) -> None:
        if any(abs(v) > 1e-6 for v in axis):
            change(axis=tuple(round(v, 4) for v in axis))

    axis = (arc.axis[0], arc.axis[1], arc.axis[2])
    degrees = round(math.degrees(arc.angle), 2)
    panel.vector("Axis of the sweep", axis, set_axis, 0.1, "Through the origin of the waypoint's frame")
    panel.number("Sweep [deg]", degrees, lambda value: change(angle=round(math.radians(value), 4)), 5.0, -360.0, 360.0)
    panel.checkbox("Rotate the gripper with it", arc.twist, lambda value: change(twist=value))


def _show_poses(panel: Panel, session: Session, waypoint: WaypointSpec) -> None:
    """Show a form for each pose of the curve."""
    name, points = waypoint.name, [tuple(point) for point in waypoint.points]

    def put(new: list[tuple[float, ...]], merge: str = "") -> None:
        session.do(lambda document: document.set(name, "points", tuple(new), merge=merge))

    def show_pose(number: int) -> None:
        pose, before, behind = points[number], points[:number], points[number + 1 :]

        def change(new: FloatArray) -> None:
            put([*before, tuple(new.tolist()), *behind], f"point {number} of {name}")

        def swap(other: int) -> None:
            if 0 <= other < len(points):
                new = [*points]
                new[number], new[other] = new[other], new[number]
                put(new)

        with panel.folder(f"Pose {number + 1} of {len(points)}") as folder:
            folder.vector("x y z [m]", position_of(pose), lambda value: change(pose_of(value, angles_of(pose))), 0.01)
            folder.vector("roll pitch yaw [deg]", angles_of(pose), lambda value: change(pose_of(position_of(pose), value)), 15.0)
            presses = {
                "Earlier": lambda: swap(number - 1),
                "Later": lambda: swap(number + 1),
                "Double": lambda: put([*before, pose, pose, *behind]),
                "Remove": lambda: put([*before, *behind]),
            }
            folder.button_row("Pose", presses)

    panel.note(f"The tip passes {len(points)} poses, given in the frame of {name}; the last one is the goal.")
    for number in range(len(points)):
        show_pose(number)
    last = points[-1] if points else tuple(IDENTITY)
    further = (last[0], last[1], round(last[2] + _POSE_STEP, 4), *last[3:])
    panel.button("Add a pose after the last", lambda: put([*points, further]))
