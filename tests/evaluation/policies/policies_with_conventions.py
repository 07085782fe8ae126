"""Policies whose first action is near the present pose, in any convention; for tests of `rlbench-pin conventions`."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from rlbench_pin.environment import (
    ActionMode,
    Discrete,
    EndEffectorPoseViaIK,
    JointPosition,
    JointVelocity,
    MoveArmThenGripper,
    ObservationConfig,
)
from rlbench_pin.evaluation.policies import PolicyContext
from rlbench_pin.evaluation.policies.mapping import encode_rotation
from rlbench_pin.observation import Observation

GOAL = np.array([0.5, 0.1, 1.0])
"""Where the policies go [m]."""
STEP = 0.02
"""How far in one action [m]."""
MODES: dict[str, ActionMode] = {
    "absolute": MoveArmThenGripper(EndEffectorPoseViaIK(), Discrete()),
    "delta": MoveArmThenGripper(EndEffectorPoseViaIK(absolute_mode=False), Discrete()),
    "joints": MoveArmThenGripper(JointPosition(), Discrete()),
    "velocities": MoveArmThenGripper(JointVelocity(), Discrete()),
}
"""What action modes state."""


def arm_numbers(convention: str, tip: np.ndarray, joints: np.ndarray, length: float = STEP) -> np.ndarray:
    """Return the numbers of the arm.

    Args:
        convention: `absolute`, `world` or `tip` (the last two are deltas) and a rotation layout, as in `tip six_rows`; or
            `joint_positions`, `joint_deltas`, `joint_velocities`.
        tip: Tip pose (7,).
        joints: Joint positions (n,) [rad].
        length: How far the tip goes [m].
    """
    kind, _, layout = convention.partition(" ")
    if not layout:
        change = 0.02 * np.sin(10.0 * joints)
        return {"joint_positions": joints + change, "joint_deltas": change, "joint_velocities": change / 0.05}[kind]
    way = GOAL - tip[:3]
    step, turn = length * way / np.linalg.norm(way), Rotation.from_rotvec([0.03, -0.02, 0.01])
    now = Rotation.from_quat(tip[3:])
    if kind == "absolute":
        step, turn = tip[:3] + step, turn * now
    elif kind == "tip":
        step, turn = now.inv().apply(step), now.inv() * turn * now
    return np.concatenate([step, encode_rotation(turn.as_quat(), layout)])


class Conventional:
    """A policy of one convention.

    Args:
        stated: Name of its action mode, one of `MODES`.
        convention: What it does instead, see `arm_numbers`; `zeros` or `noise`.
        opened: Its number of an open gripper; `closed` is that of a closed one.
        closed: See `opened`.
        length: How far the tip goes [m].
    """

    def __init__(self, stated: str, convention: str, opened: float = 1.0, closed: float = 0.0, length: float = STEP) -> None:
        self.action_mode, self.obs_config = MODES[stated], ObservationConfig()
        self.obs_config.set_all(False)
        self.obs_config.joint_positions = self.obs_config.gripper_pose = self.obs_config.gripper_open = True
        self.convention, self.opened, self.closed, self.length = convention, opened, closed, length
        self.rng, self.resets = np.random.default_rng(7), 0

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Count the episodes."""
        self.resets += 1

    def act(self, observation: Observation) -> np.ndarray:
        """Return the next action, shape (n,)."""
        if self.convention == "zeros":
            return np.zeros(8)
        if self.convention == "noise":
            return self.rng.normal(size=8)
        assert observation.gripper_pose is not None and observation.joint_positions is not None
        arm = arm_numbers(self.convention, observation.gripper_pose, observation.joint_positions, self.length)
        return np.append(arm, self.opened if observation.gripper_open else self.closed)
