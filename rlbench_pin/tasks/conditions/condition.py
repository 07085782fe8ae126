"""What every condition is: a question about the present instant."""

from __future__ import annotations

from abc import ABC, abstractmethod


class Condition(ABC):
    """Answers yes or no for the present instant.

    Conditions that remember something override `reset`, `state` and `set_state`.
    """

    @abstractmethod
    def met(self) -> bool:
        """Return whether the condition holds now."""

    def reset(self) -> None:  # noqa: B027
        """Forget what was remembered; called once the world of a new episode has settled."""

    def state(self) -> object:
        """Return what is remembered, as an immutable value."""
        return None

    def set_state(self, state: object) -> None:  # noqa: B027
        """Remember `state`, which `state()` returned before."""
