"""The API of RLBench as views on rlbench_pin; see `docs/compatibility.md`. Importing it registers the gymnasium ids."""

from __future__ import annotations

import sys

import gymnasium

import rlbench_pin.observation as demo
from rlbench.action_modes.action_mode import ActionMode
from rlbench.action_modes.arm_action_modes import ArmActionMode
from rlbench.action_modes.gripper_action_modes import GripperActionMode
from rlbench.environment import Environment
from rlbench.observation_config import CameraConfig, ObservationConfig
from rlbench.sim2real import RandomizeEvery, VisualRandomizationConfig
from rlbench.utils import name_to_task_class as name_to_task_class
from rlbench_pin import __version__ as __version__
from rlbench_pin.compat.known_tasks import KNOWN_TASKS, PERACT_TASKS
from rlbench_pin.gym.ids import MODES
from rlbench_pin.tasks import library_names

sys.modules[f"{__name__}.demo"] = demo

TASKS = [f"{name}.py" for name in library_names()]
"""File names of the tasks; tasks without a Python file of their own are left out."""

for task in (*KNOWN_TASKS, *PERACT_TASKS):
    for mode in MODES:
        if f"rlbench/{task}-{mode}-v0" not in gymnasium.registry:
            gymnasium.register(
                id=f"rlbench/{task}-{mode}-v0",
                entry_point="rlbench.gym:RLBenchEnv",
                nondeterministic=True,
                kwargs={"task_class": task, "observation_mode": mode},
            )

__all__ = [
    "ActionMode",
    "ArmActionMode",
    "CameraConfig",
    "Environment",
    "GripperActionMode",
    "ObservationConfig",
    "RandomizeEvery",
    "VisualRandomizationConfig",
]
