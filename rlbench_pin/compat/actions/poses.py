"""Poses that actions ask for, from the known arguments."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from rlbench_pin.environment.actions import RelativeFrame
from rlbench_pin.environment.actions import calculate_delta_pose as native_delta_pose
from rlbench_pin.spatial import FloatArray, compose


class HasTip(Protocol):
    """A robot with an arm that has a tip."""

    @property
    def arm(self) -> Any:
        """The arm."""
        ...


def calculate_delta_pose(robot: HasTip, action: Sequence[float] | FloatArray) -> FloatArray:
    """Apply a delta to the tip's pose along world axes: positions are added, the rotation is multiplied from the left.

    Args:
        robot: Whose tip.
        action: Delta pose (7,): x, y, z [m], qx, qy, qz, qw.

    Returns:
        The new pose (7,) in the world.
    """
    return native_delta_pose(tip_pose(robot), np.asarray(action, dtype=float), RelativeFrame.WORLD)


def pose_in_end_effector_frame(robot: HasTip, action: Sequence[float] | FloatArray) -> FloatArray:
    """Return the world pose (7,) of a pose that is given in the frame of the tip."""
    return compose(tip_pose(robot), np.asarray(action, dtype=float))


def tip_pose(robot: HasTip) -> FloatArray:
    """Pose (7,) of the tip in the world."""
    return np.asarray(robot.arm.get_tip().get_pose(), dtype=float)
