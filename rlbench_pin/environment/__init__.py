"""Environments that run tasks: Environment, TaskEnvironment, action modes, observations, demonstrations."""

from rlbench_pin.datasets import key_frame_actions
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
from rlbench_pin.environment.expert import expert_action
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
from rlbench_pin.environment.presets import clear_view, image_config, low_dim_config, make_environment
from rlbench_pin.environment.randomization import DynamicsRandomizationConfig, RandomizeEvery, VisualRandomizationConfig
from rlbench_pin.environment.replay import key_frames_succeed
from rlbench_pin.environment.runtime import Listener, RefusedOpening, Runtime
from rlbench_pin.environment.task_environment import TaskEnvironment

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
    "RefusedOpening",
    "RelativeFrame",
    "Runtime",
    "SafeArm",
    "SegmentReport",
    "TaskEnvironment",
    "VisualRandomizationConfig",
    "calculate_delta_pose",
    "clear_view",
    "expert_action",
    "image_config",
    "key_frame_actions",
    "key_frames_succeed",
    "library_versions",
    "low_dim_config",
    "make_environment",
    "rgb_handles_to_mask",
]
