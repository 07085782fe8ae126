from .environment import GymnasiumEnv, WindowMissing, episode_steps
from .ids import ANY_TASK, gym_id, register_ids
from .lerobot import LeRobotEnv, make_env
from .registration import register_plugin_tasks, register_task
from .vector import LazyAsyncVectorEnv

__all__ = [
    "ANY_TASK",
    "GymnasiumEnv",
    "LazyAsyncVectorEnv",
    "LeRobotEnv",
    "WindowMissing",
    "episode_steps",
    "gym_id",
    "make_env",
    "register_ids",
    "register_plugin_tasks",
    "register_task",
]
