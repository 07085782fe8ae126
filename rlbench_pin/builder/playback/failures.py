"""Why a demonstration failed, as a record: the cause in words, what touches what, and the nearest pose that the tip reaches."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from rlbench_pin.builder.contracts import Failure
from rlbench_pin.builder.playback.conditions import looked_at, success_texts
from rlbench_pin.errors import DemoError, NoIkSolution, PlanningError, ResetError, RlbenchPinError
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks import Task

_NUMBER = re.compile(r"-?\d+(\.\d+)?")


def failure_of(error: RlbenchPinError, waypoint: str, task: Task) -> Failure:
    """Return what an error of a demonstration says, with the evidence of the planning errors behind it.

    Args:
        error: What ended the demonstration.
        waypoint: Name of the waypoint on the way to which it was raised, or empty.
        task: The running task; a goal that was not reached names the conditions that do not hold.
    """
    cause = _reset_text(error) if isinstance(error, ResetError) else str(error)
    if isinstance(error, DemoError):
        open_ones = missing_conditions(task)
        cause += f" What does not hold: {'; '.join(open_ones)}." if open_ones else ""
    return Failure(cause, waypoint, pairs_of(error), nearest_pose(error))


def _reset_text(error: ResetError) -> str:
    """Return why a reset was refused: causes that differ in their numbers alone are counted together, by the first."""
    groups: dict[str, list[str]] = {}
    for cause in error.causes:
        groups.setdefault(_NUMBER.sub("#", cause), []).append(cause)
    causes = "; ".join(f"{len(alike)} x {alike[0]}" for alike in groups.values())
    return f"No layout was found in {len(error.causes)} attempts: {causes}"


def missing_conditions(task: Task) -> tuple[str, ...]:
    """Return the success conditions that do not hold now, as text."""
    held = looked_at(task.get_success_conditions())
    return tuple(text for text, holds in zip(success_texts(task), held, strict=True) if not holds)


def pairs_of(error: BaseException) -> tuple[tuple[str, str], ...]:
    """Return what touches what, by the first planning error that knows, from the error back to what it was raised from."""
    for cause in _chain(error):
        pairs = getattr(cause, "pairs", ()) if isinstance(cause, PlanningError) else ()
        if pairs:
            return tuple((str(first), str(second)) for first, second in pairs)
    return ()


def nearest_pose(error: BaseException) -> FloatArray | None:
    """Return the nearest pose (7,) that the tip reaches, where an inverse kinematics error says one, else None."""
    for cause in _chain(error):
        if isinstance(cause, NoIkSolution) and cause.nearest is not None:
            return np.array(cause.nearest, dtype=float)
    return None


def _chain(error: BaseException) -> Iterator[BaseException]:
    """Yield an error and what it was raised from, in turn."""
    seen: BaseException | None = error
    while seen is not None:
        yield seen
        seen = seen.__cause__ or seen.__context__
