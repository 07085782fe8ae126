"""Where the task stands, and how an episode may place it."""

from __future__ import annotations

import math
from collections.abc import Callable

from rlbench_pin.builder.view.posing import pose_of, position_of, turn_of
from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.widgets import Check, Item, Note, Number, Vector
from rlbench_pin.scene import PlacementSpec
from rlbench_pin.spatial import TABLE_HEIGHT


def placement_items(session: Session) -> list[Item]:
    """Return the nominal place of the root, and the bounds of random ones."""
    placement = session.spec.placement
    x, y, z = position_of(placement.pose)

    def change(key: str, value: object) -> None:
        session.do(lambda document: document.set_placement(key, value))

    def put(value: tuple[float, float, float]) -> None:
        pose = pose_of((value[0], value[1], value[2] + TABLE_HEIGHT), turn_of(placement.pose))
        change("pose", tuple(pose.tolist()))

    def turn(degrees: float) -> None:
        change("pose", tuple(pose_of((x, y, z), (0.0, 0.0, degrees)).tolist()))

    height = round(z - TABLE_HEIGHT, 4)
    return [
        Note("Where the task stands on the table; what has no other parent hangs on it."),
        Vector("x y [m], height above the table", (x, y, height), put, 0.01),
        Number("Yaw [deg]", turn_of(placement.pose)[2], turn, 15.0, -180.0, 180.0),
        Check("Same place in every episode", placement.static, lambda value: change("static", value)),
        *([] if placement.static else _bounds(placement, change)),
    ]


def _bounds(placement: PlacementSpec, change: Callable[[str, object], None]) -> list[Item]:
    low, high = (round(math.degrees(angle), 2) for angle in placement.yaw)
    footprint = placement.footprint or (0.0, 0.0)

    def patch(number: int, value: float) -> None:
        sides = [footprint[0] or 0.3, footprint[1] or 0.3]
        sides[number] = round(value, 4)
        change("footprint", tuple(sides) if all(side > 0.0 for side in sides) else None)

    return [
        Number(
            "Least random yaw [deg]", low, lambda value: change("yaw", (_radians(value), placement.yaw[1])), 5.0, -360.0, 360.0
        ),
        Number(
            "Most random yaw [deg]", high, lambda value: change("yaw", (placement.yaw[0], _radians(value))), 5.0, -360.0, 360.0
        ),
        Number("Patch x [m], 0: box around all bodies", footprint[0], lambda value: patch(0, value), 0.05, 0.0),
        Number("Patch y [m]", footprint[1], lambda value: patch(1, value), 0.05, 0.0),
    ]


def _radians(degrees: float) -> float:
    return round(math.radians(degrees), 4)
