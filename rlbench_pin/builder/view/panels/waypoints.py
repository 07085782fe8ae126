"""What can be said of a waypoint, whether the hand gets there, and how waypoints are added."""

from __future__ import annotations

from collections.abc import Callable

from rlbench_pin.builder.view.panels.curves import QUARTER_TURN, curve_items
from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.widgets import Button, Check, Choice, Fold, Item, Markup, Note, Number, Row
from rlbench_pin.builder.view.widgets.items import Shade
from rlbench_pin.builder.view.widgets.signs import Sign, sign
from rlbench_pin.scene import WaypointSpec

PATHS = ("plan", "straight", "curve")
"""How to get to a waypoint."""
HAND = ("leave", "open", "close", "amount")
"""What the hand does there."""
SHADES: dict[str, Shade] = {"free": "green", "collides": "orange", "unreachable": "red"}
"""Colours of buttons for what the stage says of a waypoint."""
_SIGNS: dict[str, Sign] = {"free": "good", "collides": "doubtful", "unreachable": "bad"}


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
        *_order_items(session, waypoint),
        Choice("Path", waypoint.path, PATHS, lambda value: _set_path(session, waypoint, value), hint="How to get there"),
        *curve_items(session, waypoint),
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
    ]


def _verdict(session: Session, name: str) -> Markup:
    verdict = session.sight.verdicts.get(name)
    if verdict is None:
        return sign("unknown", session.sight.fault or "Not looked at yet.")
    return sign(_SIGNS[verdict.standing], verdict.cause or "The hand gets there.")


def _set_path(session: Session, waypoint: WaypointSpec, path: str) -> None:
    values: dict[str, object] = {"path": path}
    if path == "curve" and waypoint.arc is None and not waypoint.points:
        values["arc"] = QUARTER_TURN
    if path != "curve":
        values |= {"arc": None, "points": None}
    session.do(lambda document: document.set_several(waypoint.name, values))


def overview_item(session: Session) -> Fold:
    """Return all waypoints in the order of visits, each with what the hand does there, and why it does not get there."""
    items: list[Item] = []
    for waypoint in in_order(session):
        verdict = session.sight.verdicts.get(waypoint.name)
        shade: Shade = "gray" if verdict is None else SHADES[verdict.standing]
        shade = "blue" if waypoint.name == session.selected else shade
        items.append(Button(_summary(waypoint), _selector(session, waypoint.name), shade, key=f"visit {waypoint.name}"))
        if verdict is not None and verdict.standing != "free":
            items.append(sign(_SIGNS[verdict.standing], verdict.cause))
    if not items:
        items.append(Note("None yet. *Add* puts one where the tip is; they are visited in the order of their numbers."))
    return Fold("Waypoints in the order of visits", items)


def in_order(session: Session) -> list[WaypointSpec]:
    """Return the waypoints by their numbers."""
    return sorted(session.spec.waypoint, key=lambda waypoint: _number(waypoint.name))


def _summary(waypoint: WaypointSpec) -> str:
    amount = waypoint.gripper
    hand = amount if isinstance(amount, str) else f"hand to {amount:g}" if amount is not None else ""
    extras = (
        waypoint.path if waypoint.path != "plan" else "",
        "through contact" if waypoint.ignore_collisions else "",
        hand,
        f"symmetry {waypoint.symmetry}" if waypoint.symmetry > 1 else "",
    )
    said = ", ".join(word for word in extras if word)
    return f"{_number(waypoint.name)} on {waypoint.parent}{f': {said}' if said else ''}"


def _number(name: str) -> int:
    digits = name.removeprefix("waypoint")
    return int(digits) if digits.isdecimal() else 0


def _selector(session: Session, name: str) -> Callable[[], None]:
    return lambda: session.select(name)


def _order_items(session: Session, waypoint: WaypointSpec) -> list[Item]:
    """Return what changes the order of visits."""
    name, names = waypoint.name, tuple(w.name for w in in_order(session))
    number = names.index(name)

    def go(index: int) -> None:
        if 0 <= index < len(names) and index != number:
            moved: list[str] = []
            session.do(lambda document: moved.append(document.move_waypoint(name, index)))
            session.select(moved[0] if moved else name)

    presses = {
        "Earlier": lambda: go(number - 1),
        "Later": lambda: go(number + 1),
        "Insert before": lambda: _insert(session, waypoint),
    }
    return [Choice("Visited as", name, names, lambda value: go(names.index(value)), "The others move up"), Row("Order", presses)]


def _insert(session: Session, waypoint: WaypointSpec) -> None:
    index = _number(waypoint.name)
    values = {"parent": waypoint.parent, "pose": waypoint.pose}
    made: list[str] = []
    session.do(lambda document: made.append(document.insert_waypoint(index, values)))
    if made:
        session.select(made[0])
