"""Results made up for tests: which episodes succeed is written as a text of one letter per episode."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rlbench_pin.evaluation.results.records import EpisodeRecord, Results

FIRST_SEED = 2**31


def episode(task: str, index: int, outcome: str, **changes: Any) -> EpisodeRecord:
    """Return a record: outcome 1 is a success, 0 ran out of steps, f is a fault."""
    success, fault = outcome == "1", outcome == "f"
    values: dict[str, Any] = {
        "task": task,
        "variation": index % 3,
        "seed": FIRST_SEED + index,
        "success": success,
        "lasts": success,
        "steps": 10 + index,
        "seconds": 0.5 * (index + 1),
        "end": "success" if success else "fault" if fault else "steps",
        "refused": {} if success else {"workspace": 2, "collision": 1},
        "collisions": int(not success),
        "max_force": 0.0 if success else 12.5,
        "violations": {"velocity": index},
        "fault": "crashed" if fault else "",
        "fault_detail": "ZeroDivisionError" if fault else "",
    }
    return EpisodeRecord(**(values | changes))


def results(outcomes: Mapping[str, str], policy: str = "noop", **changes: Any) -> Results:
    """Return results: task -> outcomes of its episodes."""
    count = max(map(len, outcomes.values()))
    values: dict[str, Any] = {
        "policy": policy,
        "settings": {"action_mode": {"arm": "JointPosition"}, "observation": {"cameras": []}, "max_steps": None},
        "task_set": " ".join(outcomes),
        "tasks": tuple(outcomes),
        "seeds": tuple(FIRST_SEED + i for i in range(count)),
        "limits": {"max_steps": 200, "max_seconds": 60.0},
        "versions": {"rlbench_pin": "0.1.0", "numpy": "2.0"},
        "commit": "",
        "episodes": tuple(episode(task, i, letter) for task, letters in outcomes.items() for i, letter in enumerate(letters)),
    }
    return Results(**(values | changes))
