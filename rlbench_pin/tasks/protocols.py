"""Protocols of the objects that conditions, placing, settling and grasping work on, and the checks that an argument is one.

A wrong argument is refused when it is given, not when it is used.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from functools import cache
from typing import Protocol, TypeVar, runtime_checkable

from numpy.typing import ArrayLike

from rlbench_pin.errors import InvalidValue
from rlbench_pin.spatial import FloatArray, PoseLike
from rlbench_pin.values import as_record, as_several, as_vector

PartT = TypeVar("PartT")


@runtime_checkable
class Placed(Protocol):
    """A body or a frame."""

    @property
    def name(self) -> str:
        """What it is called in the scene."""
        ...

    @property
    def position(self) -> FloatArray:
        """Where it is, shape (3,), world frame [m]."""
        ...


@runtime_checkable
class Volume(Protocol):
    """A sensor."""

    def detects(self, name: str) -> bool:
        """Return whether any part of a body is inside."""
        ...

    def contains(self, point: FloatArray) -> bool:
        """Return whether a point, shape (3,), world frame [m], is inside."""
        ...


@runtime_checkable
class Holder(Protocol):
    """A hand."""

    @property
    def grasped(self) -> Collection[str]:
        """Names of the bodies that are attached to it."""
        ...


@runtime_checkable
class Colored(Protocol):
    """A body that is seen."""

    @property
    def color(self) -> object:
        """Red, green, blue in 0..1, or None."""
        ...


@runtime_checkable
class Movable(Protocol):
    """A joint of an object."""

    @property
    def position(self) -> float:
        """Its value, [rad] or [m]."""
        ...


@runtime_checkable
class Posed(Protocol):
    """A frame."""

    @property
    def pose(self) -> FloatArray:
        """Its pose (7,), world frame."""
        ...


@runtime_checkable
class HasTip(Protocol):
    """An arm."""

    def tip_pose(self) -> FloatArray:
        """Return the pose (7,) of the point between the fingers, world frame."""
        ...


def as_part(value: PartT, kind: type, what: str, words: str) -> PartT:
    """Return `value`, or raise InvalidValue when it is not what a condition looks at.

    Args:
        value: What was given.
        kind: One of the protocols above.
        what: The argument, as users call it.
        words: What it has to be, and where a task finds one.
    """
    if not isinstance(value, kind):
        raise InvalidValue(what, value, f"has to be {words}")
    return value


def as_parts(values: Iterable[PartT], kind: type, what: str) -> tuple[PartT, ...]:
    """Return the entries of a list, or raise InvalidValue when it is none or one of them is no `kind`."""
    entries = as_several(values, what)
    for number, entry in enumerate(entries):
        as_record(entry, kind, f"entry {number} of {what}")
    return entries


ThingT = TypeVar("ThingT")
Rotation = tuple[float, float, float]
"""Roll, pitch, yaw [rad]."""
MOST_TURN = 1e3
"""Rotations are at most so large [rad]."""
THING = "a body or a frame, such as `self.world.body(name)`"
REGION = "a region, such as `self.world.region(name)`"
BODY = "a body, such as `self.world.body(name)`"
WORLD = "a world, such as `self.world`"


@runtime_checkable
class Thing(Placed, Protocol):
    """A body or a frame, which can be put elsewhere."""

    @property
    def pose(self) -> FloatArray:
        """Its pose (7,), world frame."""
        ...

    def set_pose(self, pose: PoseLike) -> None:
        """Put it elsewhere."""
        ...


@runtime_checkable
class Area(Protocol):
    """A region, in which things are placed."""

    @property
    def name(self) -> str:
        """What it is called in the scene."""
        ...

    @property
    def pose(self) -> FloatArray:
        """Its pose (7,), world frame."""
        ...

    @property
    def size(self) -> FloatArray:
        """Lengths (3,) along its axes [m]."""
        ...


@runtime_checkable
class Loose(Placed, Protocol):
    """A body that can be pushed."""

    def set_velocity(self, velocity: FloatArray) -> None:
        """Set linear [m/s] and angular [rad/s] velocity (6,)."""
        ...


@runtime_checkable
class Bulky(Placed, Protocol):
    """A body that says how far it reaches in any direction."""

    def extent_along(self, directions: FloatArray) -> FloatArray:
        """Return how far it reaches along unit vectors (n, 3) of the world, [[least], [most]] (2, n), from its origin [m]."""
        ...


@runtime_checkable
class Stepped(Protocol):
    """A world, as far as time passes in it."""

    def step(self) -> object:
        """Let a control tick pass."""
        ...


@runtime_checkable
class Rooted(Protocol):
    """A world, as far as its task can be put elsewhere."""

    def place_root(self, pose: PoseLike) -> None:
        """Move the root, with all that hangs on it."""
        ...


def as_things(values: Iterable[ThingT], kind: type, what: str, words: str) -> tuple[ThingT, ...]:
    """Return the entries of a list, or raise InvalidValue when it is none or one of them is not what is asked for.

    Args:
        values: What was given.
        kind: One of the protocols above.
        what: The argument, as users call it.
        words: What each entry has to be, and where a task finds one.
    """
    return tuple(as_part(entry, kind, f"entry {n} of {what}", words) for n, entry in enumerate(as_several(values, what)))


def as_rotations(low: ArrayLike, high: ArrayLike, lowest: str, highest: str) -> tuple[FloatArray, FloatArray]:
    """Return the lowest and the highest roll, pitch and yaw, each of shape (3,) [rad], or raise InvalidValue.

    Args:
        low: Lowest angles.
        high: Highest angles.
        lowest: What the former are called.
        highest: What the latter are called.
    """
    first, last = as_vector(low, 3, lowest, most=MOST_TURN), as_vector(high, 3, highest, most=MOST_TURN)
    if (first > last).any():
        raise InvalidValue(highest, high, f"has to be nowhere below {lowest}, {first.tolist()}")
    return first, last


@runtime_checkable
class Solid(Protocol):
    """Something with an extent, such as a body; frames, regions and sensors are points."""

    def bounds(self) -> FloatArray:
        """Return the lowest and highest corner (2, 3) of the box around it, in its own frame [m]."""
        ...


def is_solid(thing: object) -> bool:
    """Say whether a thing has an extent; asked in every tick, so that each class is looked at once."""
    kind: object = type(thing)
    return _is_solid(kind)


@cache
def _is_solid(kind: object) -> bool:
    return isinstance(kind, type) and issubclass(kind, Solid)
