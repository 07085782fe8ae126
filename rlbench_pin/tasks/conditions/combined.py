"""Conditions made of conditions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

from rlbench_pin.errors import TaskError
from rlbench_pin.tasks.conditions.condition import Condition
from rlbench_pin.tasks.conditions.parts import as_parts


class _Combined(Condition):
    """Has members; passes reset and state on to them.

    Args:
        members: The conditions, one at least.
    """

    def __init__(self, members: Sequence[Condition]) -> None:
        self.members = as_parts(members, Condition, f"members of {type(self).__name__}")
        if not self.members:
            raise TaskError(f"{type(self).__name__} needs at least one condition.")

    def _asked(self) -> list[bool]:
        """Evaluate every member, so that those which keep count see every instant."""
        return [member.met() for member in self.members]

    def reset(self) -> None:
        """Reset every member."""
        for member in self.members:
            member.reset()

    def state(self) -> tuple[object, ...]:
        """Return the states of the members."""
        return tuple(member.state() for member in self.members)

    def set_state(self, state: object) -> None:
        """Set the states of the members."""
        for member, value in zip(self.members, cast(tuple[object, ...], state), strict=True):
            member.set_state(value)


class AllOf(_Combined):
    """Holds while every member holds at the same instant."""

    def met(self) -> bool:
        """Return whether all members hold now; every one is evaluated."""
        return all(self._asked())


class AnyOf(_Combined):
    """Holds while at least one member holds."""

    def met(self) -> bool:
        """Return whether a member holds now; every one is evaluated."""
        return any(self._asked())


class InOrder(_Combined):
    """Holds once every member has held in turn, and from then on until reset.

    Each evaluation passes as many consecutive members as hold right now and stops at the first that does not. What was
    passed stays passed, so members need not hold together.

    Args:
        members: The conditions in the order in which they have to hold, one at least.
    """

    def __init__(self, members: Sequence[Condition]) -> None:
        super().__init__(members)
        self.passed = 0

    def met(self) -> bool:
        """Pass the members that hold now, in turn, and return whether all have been passed."""
        while self.passed < len(self.members) and self.members[self.passed].met():
            self.passed += 1
        return self.passed == len(self.members)

    def reset(self) -> None:
        """Begin with the first member again."""
        super().reset()
        self.passed = 0

    def state(self) -> tuple[object, ...]:
        """Return how many members were passed, then the states of all."""
        return (self.passed, *super().state())

    def set_state(self, state: object) -> None:
        """Set how many members were passed, and the states of all."""
        passed, *members = cast(tuple[object, ...], state)
        self.passed = cast(int, passed)
        super().set_state(tuple(members))
