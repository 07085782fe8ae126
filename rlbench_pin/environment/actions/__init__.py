"""What actions mean: arm modes, gripper modes, and both together."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.environment.actions.action_mode import ActionMode, JointPositionActionMode, MoveArmThenGripper
from rlbench_pin.environment.actions.arm_mode import ArmActionMode, RelativeFrame, calculate_delta_pose
from rlbench_pin.environment.actions.gripper import Discrete, GripperActionMode, GripperJointPosition
from rlbench_pin.environment.actions.joint import JointPosition, JointTorque, JointVelocity
from rlbench_pin.environment.actions.pose import EndEffectorPoseViaIK, EndEffectorPoseViaPlanning, ERJointViaIK
from rlbench_pin.environment.actions.safe_arm import SafeArm, unwrapped
from rlbench_pin.environment.actions.specification import ActionSpec
from rlbench_pin.environment.actions.twist import EndEffectorVelocity
from rlbench_pin.front_door import front_door

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

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
