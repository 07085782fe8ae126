"""What can be said of a waypoint, whether the hand gets there, and how waypoints are added."""

from __future__ import annotations

import math

from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.widgets import Button, Check, Choice, Item, Markup, Note, Number, Vector
from rlbench_pin.builder.view.widgets.signs import Sign, sign
from rlbench_pin.scene import WaypointSpec
from rlbench_pin.scene.spec import ArcSpec

PATHS = ("plan", "straight", "curve")
"""How to get to a waypoint."""
HAND = ("leave", "open", "close", "amount")
"""What the hand does there."""
_SIGNS: dict[str, Sign] = {"free": "good", "collides": "doubtful", "unreachable": "bad"}
_QUARTER = 1.5708


def waypoint_items(session: Session, waypoint: WaypointSpec) -> list[Item]:
    """Return the verdict on a waypoint, and its extras."""
    name, amount = waypoint.name, waypoint.gripper

    def change(key: str, value: object) -> None:
        session.do(lambda document: document.set(name, key, value, merge=f"{key} of {name}"))

    def hand(word: str) -> None:
        change("gripper", {"leave": None, "amount": 0.5}.get(word, word))

    word = "leave" if amount is None else amount if isinstance(amount, str) else "amount"
    opening: list[Item] = []
    if word == "amount" and not isinstance(amount, str) and amount is not None:
        opening = [Number("Opening, 0 shut to 1", amount, lambda value: change("gripper", round(value, 3)), 0.05, 0.0, 1.0)]
    return [
        _verdict(session, name),
        Choice("Path", waypoint.path, PATHS, lambda value: _set_path(session, waypoint, value), hint="How to get there"),
        *_arc_items(session, waypoint),
        Check("Ignore collisions", waypoint.ignore_collisions, lambda value: change("ignore_collisions", value), "For contact"),
        Choice("Hand", word, HAND, hand, hint="After arriving"),
        *opening,
        Number(
            "Symmetry",
            waypoint.symmetry,
            lambda value: change("symmetry", min(max(round(value), 1), 12)),
            1.0,
            1.0,
            12.0,
            hint="The hand may arrive turned about its z by any multiple of one turn divided by this",
        ),
        Button("Insert a waypoint before it", lambda: _insert(session, waypoint)),
    ]


def _verdict(session: Session, name: str) -> Markup:
    verdict = session.sight.verdicts.get(name)
    if verdict is None:
        return sign("unknown", session.sight.fault or "Not looked at yet.")
    return sign(_SIGNS[verdict.standing], verdict.cause or "The hand gets there.")


def _set_path(session: Session, waypoint: WaypointSpec, path: str) -> None:
    values: dict[str, object] = {"path": path}
    if path == "curve" and waypoint.arc is None and not waypoint.points:
        values["arc"] = {"axis": (0.0, 0.0, 1.0), "angle": _QUARTER}
    if path != "curve":
        values |= {"arc": None, "points": None}
    session.do(lambda document: document.set_several(waypoint.name, values))


def _arc_items(session: Session, waypoint: WaypointSpec) -> list[Item]:
    arc = waypoint.arc
    if waypoint.path != "curve" or arc is None:
        return [Note(f"A curve through {len(waypoint.points)} poses; edit them as text.")] if waypoint.points else []

    def change(new: ArcSpec) -> None:
        value = new.model_dump(exclude_defaults=True)
        session.do(lambda document: document.set(waypoint.name, "arc", value, merge=f"arc of {waypoint.name}"))

    def turn(axis: tuple[float, float, float]) -> None:
        if any(abs(v) > 1e-6 for v in axis):
            change(arc.model_copy(update={"axis": tuple(round(v, 4) for v in axis)}))

    def sweep(degrees: float) -> None:
        change(arc.model_copy(update={"angle": round(math.radians(degrees), 4)}))

    return [
        Vector(
            "Axis of the sweep", (arc.axis[0], arc.axis[1], arc.axis[2]), turn, 0.1, "Through the origin of the waypoint's frame"
        ),
        Number("Sweep [deg]", round(math.degrees(arc.angle), 2), sweep, 5.0, -360.0, 360.0),
        Check("Turn the hand with it", arc.twist, lambda value: change(arc.model_copy(update={"twist": value}))),
    ]


def _insert(session: Session, waypoint: WaypointSpec) -> None:
    index = int(waypoint.name.removeprefix("waypoint"))
    values = {"parent": waypoint.parent, "pose": waypoint.pose}
    made: list[str] = []
    session.do(lambda document: made.append(document.insert_waypoint(index, values)))
    if made:
        session.select(made[0])
