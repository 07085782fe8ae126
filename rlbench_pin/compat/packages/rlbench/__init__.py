"""The names of RLBench as views on rlbench_pin; see `docs/compatibility.md`. Importing it registers the gymnasium ids."""

from __future__ import annotations

from pathlib import Path

from rlbench.action_modes.action_mode import ActionMode
from rlbench.action_modes.arm_action_modes import ArmActionMode
from rlbench.action_modes.gripper_action_modes import GripperActionMode
from rlbench.backend.task import TASKS_PATH
from rlbench.environment import Environment
from rlbench.observation_config import CameraConfig, ObservationConfig
from rlbench.sim2real.domain_randomization import RandomizeEvery, VisualRandomizationConfig
from rlbench.utils import name_to_task_class as name_to_task_class
from rlbench_pin import __version__ as __version__
from rlbench_pin.compat.scenes.gym_ids import register_known_ids

TASKS = sorted(file.name for file in Path(TASKS_PATH).glob("*.py") if not file.name.startswith("_"))
"""Names of the task files."""

register_known_ids()

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
