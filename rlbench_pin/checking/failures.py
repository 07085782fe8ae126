"""Causes of failure, each counted once with its first example."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace

from rlbench_pin.checking.records import Part, Trial

_NUMBER = re.compile(r"-?\d+(\.\d+)?")


@dataclass(frozen=True)
class Failure:
    """A cause of failure, and where to see it."""

    cause: str
    count: int
    seed: int
    variation: int
    attempt: int
    waypoint: int | None
    part: Part = "demos"


def group_failures(trials: Iterable[Trial]) -> tuple[Failure, ...]:
    """Group what went wrong by cause, numbers ignored, most frequent first; each with its first example."""
    groups: dict[str, Failure] = {}
    for trial in trials:
        for found in trial.incidents():
            key = found.group or _NUMBER.sub("#", found.cause)
            first = Failure(found.cause, 0, trial.seed, trial.variation, found.attempt, found.waypoint, trial.part)
            group = groups.get(key, first)
            groups[key] = replace(group, count=group.count + 1)
    return tuple(sorted(groups.values(), key=lambda failure: -failure.count))
