"""The curve along which the hand comes to a waypoint: a circular sweep, or poses to pass."""

from __future__ import annotations

import math
from collections.abc import Callable

from rlbench_pin.builder.view.posing import pose_of, position_of, turn_of
from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.widgets import Button, Check, Choice, Fold, Item, Note, Number, Row, Vector
from rlbench_pin.scene import WaypointSpec
from rlbench_pin.scene.spec import ArcSpec
from rlbench_pin.spatial import IDENTITY, FloatArray

QUARTER_TURN: dict[str, object] = {"axis": (0.0, 0.0, 1.0), "angle": 1.5708}
"""The sweep of a new curve."""
_KINDS = ("sweep", "poses to pass")
_FIRST = (0.0, 0.0, -0.05, 0.0, 0.0, 0.0, 1.0)
_STEP = 0.02


def curve_items(session: Session, waypoint: WaypointSpec) -> list[Item]:
    """Return the forms of the curve of a waypoint; none where its path is another."""
    if waypoint.path != "curve":
        return []
    kind = _KINDS[0] if waypoint.arc is not None else _KINDS[1]

    def choose(word: str) -> None:
        values = (
            {"arc": QUARTER_TURN, "points": None} if word == _KINDS[0] else {"arc": None, "points": (_FIRST, tuple(IDENTITY))}
        )
        if word != kind:
            session.do(lambda document: document.set_several(waypoint.name, values))

    choice = Choice("Curve", kind, _KINDS, choose, "A part of a circle, or poses one after the other, in the waypoint's frame")
    return [choice, *(_sweep_items(session, waypoint, waypoint.arc) if waypoint.arc else _point_items(session, waypoint))]


def _sweep_items(session: Session, waypoint: WaypointSpec, arc: ArcSpec) -> list[Item]:
    def change(new: ArcSpec) -> None:
        value = new.model_dump(exclude_defaults=True)
        session.do(lambda document: document.set(waypoint.name, "arc", value, merge=f"arc of {waypoint.name}"))

    def turn(axis: tuple[float, float, float]) -> None:
        if any(abs(v) > 1e-6 for v in axis):
            change(arc.model_copy(update={"axis": tuple(round(v, 4) for v in axis)}))

    def sweep(degrees: float) -> None:
        change(arc.model_copy(update={"angle": round(math.radians(degrees), 4)}))

    axis = (arc.axis[0], arc.axis[1], arc.axis[2])
    return [
        Vector("Axis of the sweep", axis, turn, 0.1, "Through the origin of the waypoint's frame"),
        Number("Sweep [deg]", round(math.degrees(arc.angle), 2), sweep, 5.0, -360.0, 360.0),
        Check("Turn the hand with it", arc.twist, lambda value: change(arc.model_copy(update={"twist": value}))),
    ]


def _point_items(session: Session, waypoint: WaypointSpec) -> list[Item]:
    """Return a form for each pose that the curve passes."""
    points = [tuple(point) for point in waypoint.points]

    def put(new: list[tuple[float, ...]], merge: str = "") -> None:
        session.do(lambda document: document.set(waypoint.name, "points", tuple(new), merge=merge))

    items: list[Item] = [
        Note(f"The tip passes {len(points)} poses, given in the frame of {waypoint.name}; the last one is the goal.")
    ]
    items += [_point_item(waypoint.name, points, number, put) for number in range(len(points))]
    last = points[-1] if points else tuple(IDENTITY)
    further = (last[0], last[1], round(last[2] + _STEP, 4), *last[3:])
    return [*items, Button("Add a pose behind the last", lambda: put([*points, further]))]


def _point_item(
    name: str, points: list[tuple[float, ...]], number: int, put: Callable[[list[tuple[float, ...]], str], None]
) -> Fold:
    pose, before, behind = points[number], points[:number], points[number + 1 :]

    def change(new: FloatArray) -> None:
        put([*before, tuple(new.tolist()), *behind], f"point {number} of {name}")

    def swap(other: int) -> None:
        if 0 <= other < len(points):
            new = [*points]
            new[number], new[other] = new[other], new[number]
            put(new, "")

    presses: dict[str, Callable[[], None]] = {
        "Earlier": lambda: swap(number - 1),
        "Later": lambda: swap(number + 1),
        "Double": lambda: put([*before, pose, pose, *behind], ""),
        "Remove": lambda: put([*before, *behind], ""),
    }
    return Fold(
        f"Pose {number + 1} of {len(points)}",
        [
            Vector("x y z [m]", position_of(pose), lambda value: change(pose_of(value, turn_of(pose))), 0.01),
            Vector("roll pitch yaw [deg]", turn_of(pose), lambda value: change(pose_of(position_of(pose), value)), 15.0),
            Row("Pose", presses),
        ],
    )
