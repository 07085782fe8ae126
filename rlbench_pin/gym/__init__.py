"""Every task as a gymnasium environment; importing this package registers the ids.

The environments themselves are looked up when first used, so that registering stays light.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.front_door import front_door
from rlbench_pin.gym.ids import ANY_TASK, gym_id, register_ids

if TYPE_CHECKING:
    from rlbench_pin.gym.environment import GymnasiumEnv
    from rlbench_pin.gym.lerobot import LeRobotEnv, make_env
    from rlbench_pin.gym.own_ids import register_plugin_tasks, register_task
    from rlbench_pin.gym.vector import LazyAsyncVectorEnv
    from rlbench_pin.gym.window import WindowMissing

__all__ = [
    "ANY_TASK",
    "GymnasiumEnv",
    "LazyAsyncVectorEnv",
    "LeRobotEnv",
    "WindowMissing",
    "gym_id",
    "make_env",
    "register_ids",
    "register_plugin_tasks",
    "register_task",
]

_HOMES = {
    "GymnasiumEnv": "environment",
    "LazyAsyncVectorEnv": "vector",
    "LeRobotEnv": "lerobot",
    "WindowMissing": "window",
    "make_env": "lerobot",
    "register_plugin_tasks": "own_ids",
    "register_task": "own_ids",
}

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__, _HOMES)

register_ids()
