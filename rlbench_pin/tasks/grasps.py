"""Grasps: graspable parts of a body, the easiest grasp from above in a tray, and free directions of approach on the table."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from rlbench_pin.errors import BoundaryError, InvalidValue, UnknownName
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks.arguments import BODY_WITH_EXTENT, as_objects
from rlbench_pin.values import as_number, as_pose, as_record, as_several, as_vector

if TYPE_CHECKING:
    from rlbench_pin.sim import Body, World

SIDES = (0.0, -1.0, 1.0)
"""Positions of a body between the fingers: in the middle, or close to one of them."""
OPEN, FINGER = 0.028, 0.053
"""Maximum distance of the middle of the gripper from a side of a body, and from the middle of an open finger [m]."""
PAD = np.array([0.014, 0.016])
"""Half size of the space for a finger, along its width and its thickness [m]."""
CORNERS = np.array([[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]])
FARTHEST = 1e3
"""Upper bound of coordinates [m] and angles [rad]."""
ANGLES = 24
"""Number of compared yaw angles of the gripper."""


def graspable_part(world: World, name: str) -> tuple[Body, str]:
    """Return the body of `body` or `body/link`, and the only link by which it may be held; empty for all links.

    Raises:
        UnknownName: There is no such body, or it has no such link.
    """
    whole, _, link = name.partition("/") if isinstance(name, str) else (name, "", "")
    body = world.body(whole)
    if link and link not in body.model.links:
        raise UnknownName(f"link of body '{whole}'", link, body.model.links)
    return body, link


@dataclass(frozen=True, eq=False)
class TopGrasp:
    """A grasp from above."""

    cost: float
    """Cost: the width of the body between the fingers, plus half its distance from their middle, plus ten times the penetration
    of the fingers into a wall or another body [m]."""
    position: FloatArray
    """Middle between the fingers (3,) in the world [m], at the height of the body."""
    angle: float
    """Yaw of the gripper about the vertical [rad]."""

    def tip_pose(self, height: float | None = None) -> FloatArray:
        """Return the tip pose (7,) in the world, at a height [m] if it is given."""
        x, y, z = self.position
        turn = self.angle / 2.0
        return np.array([x, y, z if height is None else height, -np.sin(turn), np.cos(turn), 0.0, 0.0])


@dataclass(frozen=True, eq=False)
class Tray:
    """A tray in which the fingers must stay."""

    pose: FloatArray
    """Pose (7,) in the world; rotations are only about the vertical."""
    half: FloatArray
    """Half size (2,) of its inside [m]."""

    def __post_init__(self) -> None:
        """Convert to arrays, or raise InvalidValue for an invalid pose or size."""
        as_pose(self.pose, "Tray.pose")
        object.__setattr__(self, "pose", as_vector(self.pose, 7, "Tray.pose"))
        object.__setattr__(self, "half", as_vector(self.half, 2, "Tray.half"))
        if not (self.half > 0.0).all():
            raise InvalidValue("Tray.half", self.half, "has to be two lengths above 0")


def easiest_top_grasp(wanted: Sequence[Body], bodies: Sequence[Body], tray: Tray) -> TopGrasp:
    """Return the easiest grasp: across a narrow side, with space for the fingers.

    Args:
        wanted: Bodies to grasp.
        bodies: All bodies in the tray, including `wanted`.
        tray: The tray.

    Raises:
        BoundaryError: `wanted` is empty.
        InvalidValue: An argument is not a body or tray, or a wanted body is not in `bodies`.
    """
    wanted, bodies = as_objects(wanted, BODY_WITH_EXTENT, "wanted"), as_objects(bodies, BODY_WITH_EXTENT, "bodies")
    as_record(tray, Tray, "tray")
    names = [body.name for body in bodies]
    if missing := [body.name for body in wanted if body.name not in names]:
        raise InvalidValue("wanted", missing, f"has to be a subset of `bodies` ({', '.join(names) or 'empty'})")
    if not wanted:
        raise BoundaryError("There is no body to grasp, `wanted` is empty. Call easiest_top_grasp only while bodies are left.")
    angles = np.arange(ANGLES) * np.pi / ANGLES
    turns = np.moveaxis(_turn_by(angles), -1, 0)
    boxes = {body.name: _flat_boxes(body, turns) for body in bodies}
    grasps = [_best_grasp(body, side, angles, turns, boxes, tray) for body in wanted for side in SIDES]
    return min(grasps, key=lambda grasp: grasp.cost)


def free_direction(
    place: FloatArray, directions: Iterable[float], others: Iterable[FloatArray], half_width: float, length: float
) -> float | None:
    """Return the first direction in which the lane to a position is free of other objects.

    Args:
        place: Target of the gripper, x and y (2,) in the world [m].
        directions: Directions of the gripper to try, best first [rad].
        others: x and y (2,) of possible obstacles [m]; an obstacle at `place` is ignored.
        half_width: Half width of the lane [m].
        length: Length of the lane before `place` [m].

    Returns:
        The direction [rad], or None if no lane is free.

    Raises:
        InvalidValue: An argument is not a position, direction or length.
    """
    place = as_vector(place, 2, "place", most=FARTHEST)
    half_width, length = as_number(half_width, "half_width", least=0.0), as_number(length, "length", least=0.0)
    headings = _entries(directions, "directions")
    directions = [as_number(heading, "each of directions", least=-FARTHEST, most=FARTHEST) for heading in headings]
    distances = [as_vector(other, 2, "each of others", most=FARTHEST) - place for other in _entries(others, "others")]
    for direction in directions:
        ahead, side = np.array([np.cos(direction), np.sin(direction)]), np.array([-np.sin(direction), np.cos(direction)])
        if not any(0.0 < -(d @ ahead) < length and abs(d @ side) < half_width for d in distances):
            return direction
    return None


def _entries(values: object, what: str) -> tuple[Any, ...]:
    """Return the entries of a list, or the rows of an array."""
    return tuple(values) if isinstance(values, np.ndarray) and values.ndim else as_several(values, what)


def _flat_boxes(body: Body, turns: FloatArray) -> FloatArray:
    """Return the boxes (n, 2, 2), [[min], [max]] each, around a body from above along the axes of rotated grippers [m]."""
    directions = np.zeros((len(turns), 2, 3))
    directions[:, :, :2] = turns.transpose(0, 2, 1)
    return body.extent_along(directions.reshape(-1, 3)).reshape(2, len(turns), 2).transpose(1, 0, 2)


def _best_grasp(
    body: Body, side: float, angles: FloatArray, turns: FloatArray, boxes: Mapping[str, FloatArray], tray: Tray
) -> TopGrasp:
    """Return the easiest grasp of a body in the middle of the gripper or close to one of the fingers.

    Args:
        body: The body.
        side: One of `SIDES`.
        angles: Yaws of the gripper to score (n,) [rad].
        turns: The yaws as rotations (n, 2, 2).
        boxes: Box around each body in the axes of each rotated gripper (n, 2, 2) [m].
        tray: The tray.
    """
    position = body.position
    low, high = boxes[body.name][:, :, 1].T
    shift = side * np.maximum(OPEN - 0.5 * (high - low), 0.0)
    across = (0.5 * (low + high) + shift)[:, None] + np.array([-FINGER, FINGER])
    fingers = np.stack([np.broadcast_to((position[:2] @ turns)[:, :1], across.shape), across], axis=-1)
    corners = (fingers[:, :, None] + CORNERS * PAD) @ turns.transpose(0, 2, 1)[:, None] - tray.pose[:2]
    others = [box for name, box in boxes.items() if name != body.name]
    crossed = _depth_in_walls(corners @ _turn_by(2.0 * np.arctan2(tray.pose[5], tray.pose[6])), tray.half)
    for box in others:
        crossed = crossed + _depth_in_box(fingers, box)
    cost = high - low + 0.5 * np.abs(shift) + 10.0 * crossed
    best = int(cost.argmin())
    return TopGrasp(float(cost[best]), np.append(turns[best] @ fingers[best].mean(axis=0), position[2]), float(angles[best]))


def _turn_by(angle: float | FloatArray) -> FloatArray:
    """Return the rotation of a plane (2, 2) by an angle [rad], or (2, 2, n) by n angles."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def _depth_in_walls(corners: FloatArray, half: FloatArray) -> FloatArray:
    """Return the penetration (n,) of two fingers into the walls of the tray; corners (n, 2, 4, 2) in its axes [m]."""
    return np.maximum(np.abs(corners) - half, 0.0).max(axis=(2, 3)).sum(axis=1)


def _depth_in_box(fingers: FloatArray, box: FloatArray) -> FloatArray:
    """Return the penetration (n,) of two fingers (n, 2, 2) into a box (n, 2, 2) [[min], [max]], in gripper axes [m]."""
    depth = np.minimum(box[:, 1:] - fingers, fingers - box[:, :1]) + PAD
    return np.maximum(depth.min(axis=-1), 0.0).sum(axis=1)
