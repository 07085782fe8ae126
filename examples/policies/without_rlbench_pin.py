"""The same policy in an environment with only numpy and msgpack: `python without_rlbench_pin.py unix:/tmp/policy.sock`.

`policy_server.py` is next to this file; rlbench_pin has it in `rlbench_pin/evaluation/policies/`. With rlbench_pin installed
evaluates `unix:/tmp/policy.sock`, until Ctrl-C ends this here.

What to look for: action mode and observations are plain data, observations arrive as an object with their fields.
"""

from __future__ import annotations

import sys
from types import SimpleNamespace

import numpy as np
from policy_server import serve


class GoThere:
    """Tip velocities towards the ball [m/s]."""

    action_mode = {"mode": "MoveArmThenGripper", "arm": "EndEffectorVelocity", "gripper": "Discrete"}
    obs_config = {"gripper_pose": True, "task_low_dim_state": True}

    def reset(self, instruction: str, context: SimpleNamespace) -> None:
        """Begin an episode; this policy remembers nothing."""

    def act(self, observation: SimpleNamespace) -> np.ndarray:
        way = observation.task_low_dim_state[:3] - observation.gripper_pose[:3]
        return np.concatenate([np.clip(3.0 * way, -0.3, 0.3), np.zeros(3), [1.0]])


if __name__ == "__main__":
    serve(GoThere, sys.argv[1])
