"""The loop: Environment, TaskEnvironment, action modes, observations, demonstrations."""

from rlbench_pin.environment.action_mode import ActionMode, JointPositionActionMode, MoveArmThenGripper
from rlbench_pin.environment.action_spec import ActionSpec
from rlbench_pin.environment.arm_actions import ArmActionMode, RelativeFrame
from rlbench_pin.environment.convert import convert_demo, verify
from rlbench_pin.environment.convert_playing import convert_by_playing
from rlbench_pin.environment.demonstrate import DemoOutcome, LegReport
from rlbench_pin.environment.environment import Environment
from rlbench_pin.environment.extra_cameras import ExtraCamera
from rlbench_pin.environment.gripper_actions import Discrete, GripperActionMode, GripperJointPosition
from rlbench_pin.environment.joint_actions import JointPosition, JointTorque, JointVelocity
from rlbench_pin.environment.model_observations import ModelObservationConfig
from rlbench_pin.environment.noise import GaussianNoise, Identity, NoiseModel
from rlbench_pin.environment.observation_config import CameraConfig, ObservationConfig
from rlbench_pin.environment.pose_actions import EndEffectorPoseViaIK, EndEffectorPoseViaPlanning, ERJointViaIK
from rlbench_pin.environment.randomize import DynamicsRandomizationConfig, RandomizeEvery, VisualRandomizationConfig
from rlbench_pin.environment.safe_arm import SafeArm
from rlbench_pin.environment.scene import Scene
from rlbench_pin.environment.task_environment import EnvironmentState, TaskEnvironment
from rlbench_pin.environment.twist_actions import EndEffectorVelocity

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
    "SafeArm",
    "Scene",
    "TaskEnvironment",
    "VisualRandomizationConfig",
    "convert_by_playing",
    "convert_demo",
    "verify",
]
