"""What a safety filter counts: counts are whole numbers of known reasons, and only what a filter answered is counted."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.control import FilterCounts, SafeCommand
from rlbench_pin.errors import InvalidValue

WRONG: list[tuple[dict[str, object], str]] = [
    ({"ticks": -1}, "FilterCounts.ticks"),
    ({"solves": 1.5}, "FilterCounts.solves"),
    ({"interventions": True}, "FilterCounts.interventions"),
    ({"stops": float("nan")}, "FilterCounts.stops"),
    ({"reasons": {"limit": 1}}, r"FilterCounts.reasons has to map reasons \(limits, distance, braking, torque, infeasible\)"),
    ({"reasons": [("limits", 1)]}, "FilterCounts.reasons"),
    ({"reasons": {"limits": -1}}, r"FilterCounts.reasons\['limits'\]"),
]


@pytest.mark.parametrize(("values", "words"), WRONG)
def test_counts_are_counts(values: dict[str, object], words: str) -> None:
    """What is none is refused by name."""
    with pytest.raises(InvalidValue, match=words):
        FilterCounts(**values)  # type: ignore[arg-type]


def test_only_commands_are_counted() -> None:
    """A command is counted once, for each of its reasons; what is no command is refused, and nothing is counted."""
    counts = FilterCounts(ticks=2, reasons={"limits": 1})
    counts.add(SafeCommand(np.zeros(7), np.ones(7), ("limits", "distance"), (), True))
    assert (counts.ticks, counts.interventions, counts.stops) == (3, 1, 1)
    assert counts.reasons == {"limits": 2, "distance": 1}
    with pytest.raises(InvalidValue, match="command has to be a SafeCommand"):
        counts.add("stop")  # type: ignore[arg-type]
    assert counts.ticks == 3
