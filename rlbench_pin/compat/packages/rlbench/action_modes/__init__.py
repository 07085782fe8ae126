"""Action modes."""

from __future__ import annotations

from rlbench_pin.errors import RlbenchPinError

_FIRST_RELEASE = ("ActionMode", "ArmActionMode", "GripperActionMode")
"""Names of the first releases of RLBench, where this package was one module with enumerations."""


class OldActionMode(RlbenchPinError, ImportError):
    """A program imports action modes of the first releases of RLBench."""


def __getattr__(name: str) -> object:
    """Raise an error; for a name of the first releases it lists the current action modes.

    Raises:
        OldActionMode: The name is from the first releases of RLBench.
        AttributeError: The module has no such name.
    """
    if name in _FIRST_RELEASE:
        raise OldActionMode(
            f"`rlbench.action_modes.{name}` is from the first releases of RLBench, where a mode was a member such as "
            "ABS_JOINT_VELOCITY. Create an object instead: MoveArmThenGripper(JointVelocity(), Discrete()), imported from "
            "rlbench.action_modes.action_mode, .arm_action_modes and .gripper_action_modes; reset() returns (descriptions, obs)."
        )
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
