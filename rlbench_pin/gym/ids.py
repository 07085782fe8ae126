"""The gymnasium ids of tasks, as strings: this module imports no task and no simulator."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import gymnasium

from rlbench_pin.values import as_choice, as_text, as_whole

MODES = ("state", "vision")
"""Observation modes: `state` has numbers only, `vision` adds images."""
MAX_EPISODE_STEPS = 1000
"""Number of steps after which an episode is truncated; the demonstrations of all but a few tasks are shorter."""

ANY_TASK = "rlbench_pin/Task-v0"
"""The id for every task: `gymnasium.make("rlbench_pin/Task-v0", task=...)` takes a name, a task file or a class."""

_LIBRARY = Path(__file__).parents[1] / "tasks" / "library"
_ENTRY_POINT = "rlbench_pin.gym.environment:GymnasiumEnv"


_CHANGE = re.compile(r"^\[\[history\]\]", re.MULTILINE)
"""Heading of an entry of `history`; each entry increases the version of the task by one."""


def gym_id(task: str, mode: str, version: int = 1, namespace: str = "rlbench_pin") -> str:
    """Return the id of a task, such as `rlbench_pin/reach_target-state-v0`. Version 1 of a task has `-v0`.

    Args:
        task: Name of the task.
        mode: `state` or `vision`.
        version: Version of the task, from 1.
        namespace: Text before the slash.
    """
    name, number = as_text(task, "task"), as_whole(version, "version", least=1) - 1
    return f"{as_text(namespace, 'namespace')}/{name}-{as_choice(mode, 'mode', MODES)}-v{number}"


def register_ids() -> None:
    """Register all tasks of the library and `ANY_TASK` with gymnasium; registered ids are not changed."""
    register(ANY_TASK, {"task": ""})
    for file in sorted(_LIBRARY.glob("*.toml")):
        version = 1 + len(_CHANGE.findall(file.read_text(encoding="utf-8")))
        for mode in MODES:
            register(gym_id(file.stem, mode, version), {"task": file.stem, "observation_mode": mode})


def register(name: str, settings: Mapping[str, Any]) -> None:
    """Register an id whose environments are `GymnasiumEnv(**settings)`, unless it is already registered."""
    if name not in gymnasium.registry:
        gymnasium.register(id=name, entry_point=_ENTRY_POINT, max_episode_steps=MAX_EPISODE_STEPS, kwargs=dict(settings))
