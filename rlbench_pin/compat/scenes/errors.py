"""Errors of programs that run under the known names."""

from __future__ import annotations

from collections.abc import Sequence

from rlbench_pin.errors import DemoError, RlbenchPinError, TaskEnvironmentError, nearest_name
from rlbench_pin.tasks import task_names


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


class UnknownTasks(RlbenchPinError, ValueError):
    """Names that are not tasks of our library."""

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        guesses = {name: nearest_name(name, task_names()) for name in names}
        near = "".join(f" Did you mean '{guess}' for '{name}'?" for name, guess in guesses.items() if guess)
        super().__init__(f"The library has no tasks {list(names)}.{near} `rlbench-pin list` prints all {len(task_names())}.")
