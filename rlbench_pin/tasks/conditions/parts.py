"""What conditions look at, as far as they use it. A wrong thing is refused when a condition is made, not when it is asked."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Protocol, TypeVar, runtime_checkable

from rlbench_pin.errors import InvalidValue
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_record, as_several

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
