"""The gymnasium ids of all tasks. Strings only: neither a task nor a simulator is imported for them."""

from __future__ import annotations

from pathlib import Path

import gymnasium

MODES = ("state", "vision")
"""What an environment observes: numbers, or pictures as well."""
MAX_EPISODE_STEPS = 1000
"""Steps after which an episode is cut off; nearly twice the longest demonstration of the library in ticks."""

_LIBRARY = Path(__file__).parents[1] / "tasks" / "library"
_ENTRY_POINT = "rlbench_pin.gym.environment:GymnasiumEnv"


def gym_id(task: str, mode: str) -> str:
    """Return the id of a task: `rlbench_pin/reach_target-state-v0`."""
    return f"rlbench_pin/{task}-{mode}-v0"


def register_ids() -> None:
    """Register every task of the library with gymnasium; ids that are there already are left alone."""
    for file in sorted(_LIBRARY.glob("*.toml")):
        if file.with_suffix(".py").is_file():
            for mode in MODES:
                _register(file.stem, mode)


def _register(task: str, mode: str) -> None:
    name = gym_id(task, mode)
    if name not in gymnasium.registry:
        gymnasium.register(
            id=name,
            entry_point=_ENTRY_POINT,
            max_episode_steps=MAX_EPISODE_STEPS,
            kwargs={"task": task, "observation_mode": mode},
        )
