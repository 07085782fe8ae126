"""The gymnasium ids that programs know: `rlbench/<task>-state-v0` and `rlbench/<task>-vision-v0`. Strings only."""

from __future__ import annotations

import gymnasium

from rlbench_pin.compat.tasks.library import KNOWN_TASKS, PERACT_TASKS
from rlbench_pin.gym.ids import MODES


def known_id(task: str, mode: str) -> str:
    """Return the id of a task: `rlbench/reach_target-state-v0`."""
    return f"rlbench/{task}-{mode}-v0"


def register_known_ids() -> None:
    """Register every known task name with gymnasium; ids that are there already are left alone."""
    for task in (*KNOWN_TASKS, *PERACT_TASKS):
        for mode in MODES:
            name = known_id(task, mode)
            if name not in gymnasium.registry:
                gymnasium.register(
                    id=name,
                    entry_point="rlbench.gym:RLBenchEnv",
                    nondeterministic=True,
                    kwargs={"task_class": task, "observation_mode": mode},
                )
