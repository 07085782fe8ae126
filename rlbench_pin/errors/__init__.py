"""The errors that callers catch, by area; `RlbenchPinError` is the base of them all.

Each message names the thing, the value, what was possible, and the next step. The evidence is attached as attributes.
A few errors that one module alone raises are defined there, each derived from one of these.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.errors.base import (
    InvalidValue,
    MissingExtra,
    RlbenchPinError,
    UnknownName,
    UnknownSetting,
    install_hint,
    nearest_name,
    shown,
)
from rlbench_pin.errors.control import (
    ControlError,
    InfeasibleControl,
    InvalidTarget,
)
from rlbench_pin.errors.datasets import (
    DatasetConflict,
    DatasetError,
    EpisodeFileError,
    StorageError,
    UntrustedTaskFile,
)
from rlbench_pin.errors.environment import (
    CameraError,
    EnvironmentClosed,
    InvalidActionError,
    InvalidArgument,
    InvalidCamera,
    NoShapedReward,
    NotReset,
    ResetError,
    TaskEnvironmentError,
)
from rlbench_pin.errors.evaluation import (
    EvaluationError,
    IncompatibleResults,
    MissingTasks,
    ResultsFileError,
)
from rlbench_pin.errors.planning import (
    GoalInCollision,
    InvalidRequest,
    NoIkSolution,
    NoPath,
    NotStraight,
    OutsideJointLimits,
    PlanningError,
    ProblemFileError,
    RetimingError,
    StartInCollision,
)
from rlbench_pin.errors.scenes import (
    AssetInvalid,
    AssetNotFound,
    InvalidRecord,
    RobotModelError,
    SceneFileError,
)
from rlbench_pin.errors.tasks import (
    BoundaryError,
    DemoError,
    NoWaypointsError,
    TaskError,
    WaypointError,
)
from rlbench_pin.front_door import front_door

__all__ = [
    "AssetInvalid",
    "AssetNotFound",
    "BoundaryError",
    "CameraError",
    "ControlError",
    "DatasetConflict",
    "DatasetError",
    "DemoError",
    "EnvironmentClosed",
    "EpisodeFileError",
    "EvaluationError",
    "GoalInCollision",
    "IncompatibleResults",
    "InfeasibleControl",
    "InvalidActionError",
    "InvalidArgument",
    "InvalidCamera",
    "InvalidRecord",
    "InvalidRequest",
    "InvalidTarget",
    "InvalidValue",
    "MissingExtra",
    "MissingTasks",
    "NoIkSolution",
    "NoPath",
    "NoShapedReward",
    "NoWaypointsError",
    "NotReset",
    "NotStraight",
    "OutsideJointLimits",
    "PlanningError",
    "ProblemFileError",
    "ResetError",
    "ResultsFileError",
    "RetimingError",
    "RlbenchPinError",
    "RobotModelError",
    "SceneFileError",
    "StartInCollision",
    "StorageError",
    "TaskEnvironmentError",
    "TaskError",
    "UnknownName",
    "UnknownSetting",
    "UntrustedTaskFile",
    "WaypointError",
    "install_hint",
    "nearest_name",
    "shown",
]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
