"""What goes wrong with the stage: its process dies or hangs, it was stopped, it is busy, or nothing is open."""

from __future__ import annotations

from typing import Literal

from rlbench_pin.builder.contracts import Problem
from rlbench_pin.errors import RlbenchPinError

FaultKind = Literal["crashed", "timed out", "out of memory", "failed"]
"""How the process failed; after `failed` it lives on."""
_SENTENCES: dict[FaultKind, str] = {
    "crashed": "died",
    "timed out": "did not answer in time",
    "out of memory": "ran out of memory",
    "failed": "failed",
}


class StageFault(RlbenchPinError):
    """The process of the stage failed in an operation. The next operation starts it anew and opens the task again.

    Args:
        kind: How it failed.
        operation: During what.
        detail: What happened, and the next step.
        printed: The last lines that the process printed.
        problem: The line of the task at which it happened, where one is known.
    """

    def __init__(self, kind: FaultKind, operation: str, detail: str, printed: str = "", problem: Problem | None = None) -> None:
        self.kind: FaultKind = kind
        self.operation, self.detail, self.printed, self.problem = operation, detail, printed, problem
        where = "" if problem is None or problem.line is None else f" It was at line {problem.line} of the {problem.file} file."
        ending = f"\nIt printed last:\n{printed}" if printed else ""
        super().__init__(f"The simulation {_SENTENCES[kind]} during `{operation}`: {detail}{where}{ending}")


class StageStopped(RlbenchPinError):
    """An operation was ended by `cancel`."""

    def __init__(self, operation: str) -> None:
        self.operation = operation
        super().__init__(f"`{operation}` was stopped.")


class StageBusy(RlbenchPinError):
    """Another operation runs; nothing was done."""

    def __init__(self, operation: str, running: str) -> None:
        self.operation, self.running = operation, running
        super().__init__(f"`{operation}` has to wait until `{running}` is done. Wait for it, or `cancel()` it.")


class NothingOpen(RlbenchPinError):
    """No task is open, or the one that was opened could not be built."""

    def __init__(self, operation: str, why: str = "no task was opened. Call `open` first.") -> None:
        self.operation = operation
        super().__init__(f"`{operation}` needs an open task: {why}")


class StageClosed(RlbenchPinError):
    """The stage was closed."""

    def __init__(self, operation: str) -> None:
        self.operation = operation
        super().__init__(f"`{operation}` was asked of a stage that was closed. Make a new StageClient.")
