"""The calls that built a world, kept so that they can be made again."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from rlbench_pin.errors import RlbenchPinError


@dataclass(frozen=True)
class Change:
    """One call that changed a physics server, and what it returned."""

    function: Callable[..., Any]
    positional: tuple[Any, ...]
    named: Mapping[str, Any]
    result: Any

    def repeat(self) -> None:
        """Make the call again.

        Raises:
            RlbenchPinError: It failed, or returned something else this time.
        """
        name = self.function.__name__
        try:
            result = self.function(*self.positional, **self.named)
        except Exception as error:
            problem = f"{name}{self.positional} failed: {error}"
        else:
            if result == self.result:
                return
            problem = f"{name}{self.positional} gave {result} instead of {self.result}"
        raise RlbenchPinError(
            f"The world could not be built again: {problem}. Restore the files it was built from, and load the task again."
        )


class Journal:
    """Records calls, in order, until it is closed."""

    def __init__(self) -> None:
        self._changes: list[Change] = []
        self._closed = False

    @property
    def changes(self) -> tuple[Change, ...]:
        """The recorded calls, in order."""
        return tuple(self._changes)

    def call(self, function: Callable[..., Any], *positional: Any, **named: Any) -> Any:
        """Call a function and return its result; the call is recorded unless the journal is closed."""
        result = function(*positional, **named)
        if not self._closed:
            self._changes.append(Change(function, positional, named, result))
        return result

    def close(self) -> None:
        """Record nothing from now on."""
        self._closed = True

    def repeat(self) -> None:
        """Make all recorded calls again.

        Raises:
            RlbenchPinError: One of them failed, or returned something else this time.
        """
        for change in self._changes:
            change.repeat()
