"""Wrong use of the environment, start states that were not found, and cameras."""

from __future__ import annotations

from collections.abc import Sequence

from rlbench_pin.errors.base import InvalidValue, RlbenchPinError


class InvalidActionError(RlbenchPinError):
    """An action was refused; the world is as it was before.

    Args:
        message: What is wrong with it, and what to do.
        cause: The kind of fault in a few words, the same for all of its kind; that of a motion that was not found is the
            `reason` of the planner.
    """

    def __init__(self, message: str = "", cause: str = "invalid") -> None:
        self.cause = cause
        super().__init__(message)


class TaskEnvironmentError(RlbenchPinError):
    """The environment was used in a way that it cannot serve."""


class InvalidArgument(TaskEnvironmentError, InvalidValue):
    """An environment was given a seed, a variation, a number or a setting that means nothing."""


class NotReset(TaskEnvironmentError, RuntimeError):
    """An episode was used before it was started."""

    def __init__(self, call: str) -> None:
        super().__init__(f"`{call}` was called before the first reset. Call `reset()` first.")


class NoShapedReward(TaskEnvironmentError, RuntimeError):
    """Shaped rewards were asked for, but the task gives none."""

    def __init__(self, task: str) -> None:
        super().__init__(f"Task '{task}' has no shaped reward. Use shaped_rewards=False, or give the task a `reward()`.")


class ResetError(TaskEnvironmentError):
    """No start state was found; carries why each attempt failed."""

    def __init__(self, task: str, causes: Sequence[str]) -> None:
        self.causes = tuple(causes)
        counts = {c: self.causes.count(c) for c in dict.fromkeys(self.causes)}
        text = "; ".join(f"{n} x {c}" for c, n in counts.items())
        super().__init__(f"Task '{task}' could not be placed in {len(self.causes)} attempts: {text}.")


class EnvironmentClosed(TaskEnvironmentError, RuntimeError):
    """A world was used after it was shut down."""


class CameraError(RlbenchPinError):
    """A camera was asked for something it cannot deliver."""


class InvalidCamera(CameraError, InvalidValue):
    """A camera was given a size, a pose or a setting with which no picture can be taken."""
