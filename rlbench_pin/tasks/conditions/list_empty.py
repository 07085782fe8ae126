"""A list of the task is empty."""

from __future__ import annotations

from collections.abc import Sized

from rlbench_pin.errors import InvalidValue
from rlbench_pin.tasks.conditions.condition import Condition


class ListEmpty(Condition):
    """Holds while a list that the task keeps has no entries left.

    Args:
        items: The list itself; change it in place.
    """

    def __init__(self, items: Sized) -> None:
        try:
            len(items)
        except Exception as error:  # of whatever it is
            raise InvalidValue("items", items, "has to be a list, or something else that has a length") from error
        self.items = items

    def met(self) -> bool:
        """Return whether the list is empty now."""
        return len(self.items) == 0
