"""Errors of programs that run under the known names."""

from __future__ import annotations

from collections.abc import Sequence

from rlbench_pin.errors import DemoError, TaskEnvironmentError


class NotPlaced(TaskEnvironmentError):
    """No start of an episode was found."""

    def __init__(self, task: str, variation: int, cause: Exception) -> None:
        self.task, self.variation = task, variation
        super().__init__(f"Variation {variation} of task '{task}' could not be started: {cause}")


class DemosFailed(DemoError, RuntimeError):
    """A live demonstration failed at every try; `causes` says why."""

    def __init__(self, task: str, variation: int, causes: Sequence[str]) -> None:
        self.causes = tuple(causes)
        text = "; ".join(f"try {i + 1}: {cause}" for i, cause in enumerate(causes))
        super().__init__(
            f"Variation {variation} of task '{task}' could not be demonstrated in {len(causes)} tries ({text}). "
            f"`rlbench-pin check {task}` shows how often that happens."
        )
