"""Evaluations: results files that cannot be read, or not be compared, and sets of tasks that are not all there."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rlbench_pin.errors.base import RlbenchPinError


class EvaluationError(RlbenchPinError, RuntimeError):
    """An evaluation cannot be made, read or compared."""


class ResultsFileError(EvaluationError):
    """A results file is missing, damaged, altered or of another format; `path` says which."""

    def __init__(self, path: Path | str, problem: str, advice: str = "") -> None:
        self.path, self.problem = Path(path), problem
        advice = advice or "Take it from where it was made again, or run the evaluation again: `rlbench-pin evaluate` writes it."
        super().__init__(f"'{path}' is no results file that can be used: {problem}. {advice}")


class IncompatibleResults(EvaluationError):
    """Two results files do not hold the same episodes, so that they cannot be compared one by one.

    Attributes:
        differences: What differs, one text each.
    """

    def __init__(self, first: str, second: str, differences: Sequence[str], advice: str) -> None:
        self.differences = tuple(differences)
        super().__init__(f"The results of '{first}' and '{second}' cannot be compared: {'; '.join(differences)}. {advice}")


class MissingTasks(EvaluationError):
    """Tasks of a set are known by name, but not built yet.

    Attributes:
        asked: What was asked for.
        missing: Names of the tasks that are missing.
        available: Names of those that are there.
    """

    def __init__(self, asked: str, missing: Sequence[str], available: Sequence[str]) -> None:
        self.asked, self.missing, self.available = asked, tuple(missing), tuple(available)
        rest = (
            f"`--available` (`available_only=True` in Python) takes the {len(self.available)} that are there."
            if self.available
            else "`rlbench-pin list --sets` says what there is of each set."
        )
        super().__init__(
            f"{asked}: {len(self.missing)} of {len(self.missing) + len(self.available)} tasks are not built yet: "
            f"{', '.join(self.missing)}. {rest}"
        )
