"""Robot manipulation tasks with planned demonstrations, on Pinocchio and PyBullet.

The names below are all that most programs need; everything else is a name of one of the packages, such as
`rlbench_pin.planning.MotionPlanner`. Both are looked up when first used, so that importing the package starts nothing and reads
nothing. Where gymnasium is installed, the ids `rlbench_pin/<task>-state-v0` and `-vision-v0` are
registered with it.
"""

from __future__ import annotations

import sys

if sys.argv[:1] == ["-m"] and "rlbench_pin.cli.main" in sys.orig_argv:  # the command line: Ctrl-C is quiet from here on
    from rlbench_pin.cli.interrupts import end_quietly

    end_quietly()

import importlib
import importlib.util
import logging
from typing import TYPE_CHECKING

from rlbench_pin.front_door import front_door

if TYPE_CHECKING:
    from rlbench_pin import (
        checking,
        control,
        datasets,
        environment,
        errors,
        evaluation,
        observation,
        planning,
        recording,
        robot,
        scene,
        sim,
        spatial,
        tasks,
        urdf,
        values,
    )
    from rlbench_pin.environment import (
        ActionMode,
        CameraConfig,
        Discrete,
        EndEffectorPoseViaIK,
        EndEffectorPoseViaPlanning,
        EndEffectorVelocity,
        Environment,
        GripperJointPosition,
        JointPosition,
        JointTorque,
        JointVelocity,
        MoveArmThenGripper,
        ObservationConfig,
        RandomizeEvery,
        RelativeFrame,
        SafeArm,
        TaskEnvironment,
        VisualRandomizationConfig,
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
    "EndEffectorPoseViaIK",
    "EndEffectorPoseViaPlanning",
    "EndEffectorVelocity",
    "Environment",
    "GripperJointPosition",
    "JointPosition",
    "JointTorque",
    "JointVelocity",
    "MoveArmThenGripper",
    "Observation",
    "ObservationConfig",
    "RandomizeEvery",
    "RelativeFrame",
    "RlbenchPinError",
    "SafeArm",
    "TaskEnvironment",
    "VisualRandomizationConfig",
    "task_class",
    "task_names",
]

_HOMES = dict.fromkeys(__all__, "environment") | {
    "Demo": "observation",
    "Observation": "observation",
    "RlbenchPinError": "errors",
    "task_class": "tasks",
    "task_names": "tasks",
}
_PARTS = (
    "checking", "compat", "control", "datasets", "environment", "errors", "evaluation", "gym", "observation", "planning",
    "recording", "robot", "scene", "sim", "spatial", "tasks", "urdf", "values",
)  # fmt: skip

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__, _HOMES, _PARTS)

logging.getLogger(__name__).addHandler(logging.NullHandler())
if importlib.util.find_spec("gymnasium") is not None:
    importlib.import_module("rlbench_pin.gym")  # registers the ids
