"""Checks of arguments of tasks: objects of a world, by the attributes that are used, and rotations.

An invalid argument raises an error when it is passed, not when it is used. The checks import no simulator.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple, TypeVar

from numpy.typing import ArrayLike

from rlbench_pin.errors import InvalidValue
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_several, as_vector

ObjectT = TypeVar("ObjectT")
Rotation = tuple[float, float, float]
"""Roll, pitch, yaw [rad]."""
MAX_TURN = 1e3
"""Upper bound of rotations [rad]."""
_BODY = "a body, such as `self.world.body(name)`"


class ObjectKind(NamedTuple):
    """A kind of object in a world."""

    words: str
    """Name of the kind, with an example for a task."""
    attributes: tuple[str, ...]
    """Attributes that are used."""


BODY_OR_FRAME = ObjectKind("a body or a frame", ("name", "position"))
MOVABLE = ObjectKind("a body or a frame, such as `self.world.body(name)`", ("name", "position", "pose", "set_pose"))
POSED = ObjectKind("a body or a frame, such as `self.world.body(name)`", ("name", "pose"))
BODY = ObjectKind(_BODY, ("name", "position"))
COLORED_BODY = ObjectKind(_BODY, ("color",))
LOOSE_BODY = ObjectKind(_BODY, ("name", "position", "set_velocity"))
BODY_WITH_EXTENT = ObjectKind(_BODY, ("name", "position", "extent_along"))
FRAME = ObjectKind("a frame, or None for the world", ("pose",))
REGION = ObjectKind("a region, such as `self.world.region(name)`", ("name", "pose", "size"))
SENSOR = ObjectKind("a sensor, such as `self.world.sensor(name)`", ("detects", "contains"))
JOINT = ObjectKind("a joint, such as `self.world.joint(name)`", ("position",))
GRIPPER = ObjectKind("the gripper, `self.gripper`", ("held",))
ARM = ObjectKind("the arm, `self.robot`", ("tip_pose",))
STEPPED_WORLD = ObjectKind("a world, such as `self.world`", ("step",))
ROOTED_WORLD = ObjectKind("a world, such as `self.world`", ("place_root",))


def as_object(value: ObjectT, kind: ObjectKind, what: str) -> ObjectT:
    """Return `value`, or raise InvalidValue if it is not of the kind; `what` is the name of the argument in the message."""
    if not all(hasattr(value, name) for name in kind.attributes):
        raise InvalidValue(what, value, f"has to be {kind.words}")
    return value


def as_objects(values: Iterable[ObjectT], kind: ObjectKind, what: str) -> tuple[ObjectT, ...]:
    """Return the entries of a list, or raise InvalidValue if it is not a list or an entry is not of the kind."""
    return tuple(as_object(entry, kind, f"entry {n} of {what}") for n, entry in enumerate(as_several(values, what)))


def as_rotations(low: ArrayLike, high: ArrayLike, lowest: str, highest: str) -> tuple[FloatArray, FloatArray]:
    """Return the lowest and the highest roll, pitch and yaw, each of shape (3,) [rad], or raise InvalidValue.

    Args:
        low: Lowest angles.
        high: Highest angles.
        lowest: Name of `low` in messages.
        highest: Name of `high` in messages.
    """
    first, last = as_vector(low, 3, lowest, most=MAX_TURN), as_vector(high, 3, highest, most=MAX_TURN)
    if (first > last).any():
        raise InvalidValue(highest, high, f"has to be at least {lowest}, {first.tolist()}, in each entry")
    return first, last


def has_extent(value: object) -> bool:
    """Return whether an object has an extent, as bodies do; frames, regions and sensors are points."""
    return hasattr(type(value), "bounds")
