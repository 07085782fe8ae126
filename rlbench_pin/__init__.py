"""Robot manipulation tasks with planned demonstrations, on Pinocchio and PyBullet.

The names below are all that most programs need. They are looked up when first used, so that importing the package
starts nothing and reads nothing. Where gymnasium is installed, the ids `rlbench_pin/<task>-state-v0` and `-vision-v0` are
registered with it.
"""

from __future__ import annotations

import importlib
import importlib.util
import logging
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rlbench_pin.environment import (
        ActionMode,
        CameraConfig,
        Discrete,
        EndEffectorPoseViaPlanning,
        Environment,
        JointPosition,
        JointVelocity,
        MoveArmThenGripper,
        ObservationConfig,
        SafeArm,
        TaskEnvironment,
    )
    from rlbench_pin.errors import RlbenchPinError
    from rlbench_pin.observation import Demo, Observation
    from rlbench_pin.tasks import task_class, task_names

__version__ = "0.1.0"

__all__ = [
    "ActionMode",
    "CameraConfig",
    "Demo",
    "Discrete",
    "EndEffectorPoseViaPlanning",
    "Environment",
    "JointPosition",
    "JointVelocity",
    "MoveArmThenGripper",
    "Observation",
    "ObservationConfig",
    "RlbenchPinError",
    "SafeArm",
    "TaskEnvironment",
    "task_class",
    "task_names",
]

_HOMES = {
    "Demo": "observation",
    "Observation": "observation",
    "RlbenchPinError": "errors",
    "task_class": "tasks",
    "task_names": "tasks",
}

logging.getLogger(__name__).addHandler(logging.NullHandler())
if importlib.util.find_spec("gymnasium") is not None:
    importlib.import_module("rlbench_pin.gym")  # registers the ids


def __getattr__(name: str) -> object:
    """Import the home of a public name when the name is first asked for."""
    if name not in __all__:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    home = importlib.import_module(f"{__name__}.{_HOMES.get(name, 'environment')}")
    value: object = getattr(home, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """List the public names, loaded or not."""
    return sorted({*globals(), *__all__})
