"""What the networks see of an observation, and what their numbers between -1 and 1 do."""

from __future__ import annotations

import numpy as np

from rlbench_pin.observation import Observation
from rlbench_pin.spatial import FloatArray

REACH = 0.05
"""Joint difference of a control tick at most [rad]: 1 rad/s."""
EPSILON = 1e-4
"""Added to variances of features: what hardly varies is divided by 1 cm or 0.01 rad, not by next to nothing."""
TICKS = 3
"""Control ticks that a decision lasts: 0.15 s. An episode of fewer decisions is learned sooner."""


def features(observation: Observation) -> np.ndarray:
    """Return joints [rad], opening of the hand, pose of the tip, state of the task, and its first place seen from the tip [m].

    Args:
        observation: With the low-dimensional fields.

    Returns:
        float32, shape (joints + 11 + numbers of the state,).
    """
    tip = np.asarray(observation.gripper_pose, dtype=np.float64)
    state = np.asarray(observation.task_low_dim_state, dtype=np.float64)
    joints = np.asarray(observation.joint_positions, dtype=np.float64)
    hand = float(observation.gripper_open or 0.0)
    return np.concatenate([joints, [hand], tip, state, state[:3] - tip[:3]]).astype(np.float32)


def as_command(unit: FloatArray, high: FloatArray) -> FloatArray:
    """Return an action of `JointPositionActionMode`.

    Args:
        unit: A difference for each joint and the hand, open above 0, between -1 and 1, shape (joints + 1,).
        high: Highest value of each number of the action; the last is the position of an open finger [m].
    """
    values = np.clip(np.asarray(unit, dtype=np.float64), -1.0, 1.0)
    return np.append(REACH * values[:-1], high[-1] if values[-1] > 0.0 else 0.0)


def as_unit(joints: FloatArray, target: FloatArray, is_open: bool) -> FloatArray:
    """Return the numbers between -1 and 1 that go towards joint positions.

    Args:
        joints: Where the joints are [rad].
        target: Where they should be a decision later [rad].
        is_open: Whether the hand should be open.
    """
    return np.append(np.clip((target - joints) / (TICKS * REACH), -1.0, 1.0), 1.0 if is_open else -1.0)
