"""Environments that run tasks: Environment, TaskEnvironment, action modes, observations, demonstrations."""

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
)
from rlbench_pin.environment.demonstrate import DemoOutcome, LegReport
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
from rlbench_pin.environment.randomization import DynamicsRandomizationConfig, RandomizeEvery, VisualRandomizationConfig
from rlbench_pin.environment.runtime import Runtime
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
    "LegReport",
    "ModelObservationConfig",
    "MoveArmThenGripper",
    "NoiseModel",
    "ObservationConfig",
    "RandomizeEvery",
    "RelativeFrame",
    "Runtime",
    "SafeArm",
    "TaskEnvironment",
    "VisualRandomizationConfig",
    "rgb_handles_to_mask",
]
