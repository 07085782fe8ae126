"""Which tasks the few-shot and multi-task sets hold, as dicts with `train` and, where there is a split, `test`."""

from __future__ import annotations

from rlbench_pin.evaluation.sets import task_set

SPLIT = ("FS10_V1", "FS25_V1", "FS50_V1", "FS95_V1")
WHOLE = ("MT15_V1", "MT30_V1", "MT55_V1", "MT100_V1")

TASK_SETS: dict[str, dict[str, tuple[str, ...]]] = {
    **{name: dict(task_set(name).parts) for name in SPLIT},
    **{name: {"train": task_set(name).tasks} for name in WHOLE},
}
"""Name of the set -> `train` and, in few-shot sets, `test` -> names of tasks, built or not."""
