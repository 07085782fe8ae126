"""What the action modes under the known names are made of."""

from rlbench_pin.compat.actions.frames import RelativeFrame
from rlbench_pin.compat.actions.parts import ScenePart
from rlbench_pin.compat.actions.planned_pose import OnStep, plan_motion, run
from rlbench_pin.compat.actions.poses import calculate_delta_pose, pose_in_end_effector_frame
from rlbench_pin.compat.actions.shapes import assert_action_shape
from rlbench_pin.compat.actions.user_mode import Action, UserMode

__all__ = [
    "Action",
    "OnStep",
    "RelativeFrame",
    "ScenePart",
    "UserMode",
    "assert_action_shape",
    "calculate_delta_pose",
    "plan_motion",
    "pose_in_end_effector_frame",
    "run",
]
