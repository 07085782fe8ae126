"""The loop: Environment, TaskEnvironment, action modes, observations, demonstrations."""

from rlbench_pin.environment.actions.action_mode import ActionMode, JointPositionActionMode, MoveArmThenGripper
from rlbench_pin.environment.actions.arm_mode import ArmActionMode, RelativeFrame
from rlbench_pin.environment.actions.gripper import Discrete, GripperActionMode, GripperJointPosition
from rlbench_pin.environment.actions.joint import JointPosition, JointTorque, JointVelocity
from rlbench_pin.environment.actions.pose import EndEffectorPoseViaIK, EndEffectorPoseViaPlanning, ERJointViaIK
from rlbench_pin.environment.actions.safe_arm import SafeArm
from rlbench_pin.environment.actions.specification import ActionSpec
from rlbench_pin.environment.actions.twist import EndEffectorVelocity
from rlbench_pin.environment.demonstrate import DemoOutcome, LegReport
from rlbench_pin.environment.environment import Environment
from rlbench_pin.environment.observations.config import CameraConfig, ObservationConfig
from rlbench_pin.environment.observations.extra_cameras import ExtraCamera
from rlbench_pin.environment.observations.model_based import ModelObservationConfig
from rlbench_pin.environment.observations.noise import GaussianNoise, Identity, NoiseModel
from rlbench_pin.environment.randomization.config import DynamicsRandomizationConfig, RandomizeEvery, VisualRandomizationConfig
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.environment.task_environment import EnvironmentState, TaskEnvironment

__all__ = [
    "ActionMode",
    "ActionSpec",
    "ArmActionMode",
    "CameraConfig",
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
]
