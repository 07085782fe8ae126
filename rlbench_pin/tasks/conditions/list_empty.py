"""A list of the task is empty."""

from __future__ import annotations

from collections.abc import Sized

from rlbench_pin.tasks.conditions.condition import Condition
from rlbench_pin.values import as_record


class ListEmpty(Condition):
    """Holds while a list that the task keeps has no entries left.

    Args:
        items: The list itself; change it in place.
    """

    def __init__(self, items: Sized) -> None:
        self.items = as_record(items, Sized, "items")

    def met(self) -> bool:
        """Return whether the list is empty now."""
        return len(self.items) == 0
