"""What actions mean: arm modes, gripper modes, and both together."""

from __future__ import annotations

from rlbench_pin.environment.actions.gripper import Discrete, GripperJointPosition
from rlbench_pin.environment.actions.joint import (
    EndEffectorVelocity,
    JointPosition,
    JointPositionActionMode,
    JointTorque,
    JointVelocity,
)
from rlbench_pin.environment.actions.mode import (
    ActionMode,
    ActionSpec,
    ArmActionMode,
    GripperActionMode,
    MoveArmThenGripper,
    RelativeFrame,
    calculate_delta_pose,
)
from rlbench_pin.environment.actions.pose import EndEffectorPoseViaIK, EndEffectorPoseViaPlanning, ERJointViaIK
from rlbench_pin.environment.actions.safe_arm import SafeArm, unwrapped

__all__ = [
    "ActionMode",
    "ActionSpec",
    "ArmActionMode",
    "Discrete",
    "ERJointViaIK",
    "EndEffectorPoseViaIK",
    "EndEffectorPoseViaPlanning",
    "EndEffectorVelocity",
    "GripperActionMode",
    "GripperJointPosition",
    "JointPosition",
    "JointPositionActionMode",
    "JointTorque",
    "JointVelocity",
    "MoveArmThenGripper",
    "RelativeFrame",
    "SafeArm",
    "calculate_delta_pose",
    "unwrapped",
]
