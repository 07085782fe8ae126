"""Environments that run tasks: Environment, TaskEnvironment, action modes, observations, demonstrations."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.environment.actions import (
    ActionMode,
    ActionSpec,
    ArmActionMode,
    Discrete,
    EndEffectorPoseViaIK,
    EndEffectorPoseViaPlanning,
    EndEffectorVelocity,
    ERJointViaIK,
    GripperActionMode,
    GripperJointPosition,
    JointPosition,
    JointPositionActionMode,
    JointTorque,
    JointVelocity,
    MoveArmThenGripper,
    RelativeFrame,
    SafeArm,
    calculate_delta_pose,
)
from rlbench_pin.environment.demos import DemoOutcome, SegmentReport, library_versions
from rlbench_pin.environment.environment import Environment
from rlbench_pin.environment.episode import EnvironmentState
from rlbench_pin.environment.observations import (
    Camera,
    CameraConfig,
    Cameras,
    ExtraCamera,
    GaussianNoise,
    Identity,
    ModelObservationConfig,
    NoiseModel,
    ObservationConfig,
    rgb_handles_to_mask,
)
from rlbench_pin.environment.presets import clear_view, low_dim_config, make_environment, picture_config
from rlbench_pin.environment.randomization import DynamicsRandomizationConfig, RandomizeEvery, VisualRandomizationConfig
from rlbench_pin.environment.replay import key_frame_actions, key_frames_succeed
from rlbench_pin.environment.runtime import Listener, Runtime
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.front_door import front_door

__all__ = [
    "ActionMode",
    "ActionSpec",
    "ArmActionMode",
    "Camera",
    "CameraConfig",
    "Cameras",
    "DemoOutcome",
    "Discrete",
    "DynamicsRandomizationConfig",
    "ERJointViaIK",
    "EndEffectorPoseViaIK",
    "EndEffectorPoseViaPlanning",
    "EndEffectorVelocity",
    "Environment",
    "EnvironmentState",
    "ExtraCamera",
    "GaussianNoise",
    "GripperActionMode",
    "GripperJointPosition",
    "Identity",
    "JointPosition",
    "JointPositionActionMode",
    "JointTorque",
    "JointVelocity",
    "Listener",
    "ModelObservationConfig",
    "MoveArmThenGripper",
    "NoiseModel",
    "ObservationConfig",
    "RandomizeEvery",
    "RelativeFrame",
    "Runtime",
    "SafeArm",
    "SegmentReport",
    "TaskEnvironment",
    "VisualRandomizationConfig",
    "calculate_delta_pose",
    "clear_view",
    "key_frame_actions",
    "key_frames_succeed",
    "library_versions",
    "low_dim_config",
    "make_environment",
    "picture_config",
    "rgb_handles_to_mask",
]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
