"""The learning curve of a training: a point for each leg, as JSON."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rlbench_pin.datasets import write_whole
from rlbench_pin.evaluation.baselines.cloning.storage import ModelFileError
from rlbench_pin.rates import wilson

CURVE = "curve.json"


@dataclass(frozen=True)
class CurvePoint:
    """How far a leg of the training came."""

    steps: int
    """Decisions of training so far; 0 before the first leg."""
    episodes: int
    """Episodes that ended in this leg."""
    reward: float | None
    """Their reward in the mean; None without one."""
    success: float | None
    """The share of them that succeeded, while exploring; None without one."""
    successes: int | None = None
    """Validation episodes that the most likely action won; None where there were none after this leg."""
    of: int = 0
    """Validation episodes, on seeds that training does not meet."""

    @property
    def validation(self) -> float | None:
        """The share of successes of the most likely action."""
        return None if self.successes is None else self.successes / self.of

    @property
    def interval(self) -> tuple[float, float] | None:
        """Wilson's interval of 95 % around it."""
        return None if self.successes is None else wilson(self.successes, self.of)


def write_curve(folder: Path, points: Sequence[CurvePoint]) -> None:
    """Write a curve, with intervals."""
    rows = [{**asdict(point), "wilson_95": _rounded(point.interval)} for point in points]
    write_whole(folder / CURVE, (json.dumps(rows, indent=1) + "\n").encode())


def read_curve(folder: Path | str) -> list[CurvePoint]:
    """Return the curve of a training so far, a point for each leg and one before the first.

    Args:
        folder: Of the task, in the folder of the models.

    Raises:
        ModelFileError: The file is damaged.
    """
    path = Path(folder) / CURVE
    if not path.exists():
        return []
    try:
        rows: list[dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))
        return [CurvePoint(**{name: value for name, value in row.items() if name != "wilson_95"}) for row in rows]
    except (ValueError, TypeError, AttributeError, OSError) as error:
        raise ModelFileError(path, f"is damaged ({error})") from error


def _rounded(interval: tuple[float, float] | None) -> list[float] | None:
    return None if interval is None else [round(end, 4) for end in interval]
