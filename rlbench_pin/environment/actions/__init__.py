"""Action modes of the arm, of the gripper, and of both together."""

from __future__ import annotations

from rlbench_pin.environment.actions.modes import (
    ActionMode,
    ActionSpec,
    ArmActionMode,
    Discrete,
    EndEffectorVelocity,
    GripperActionMode,
    GripperJointPosition,
    JointPosition,
    JointPositionActionMode,
    JointTorque,
    JointVelocity,
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
