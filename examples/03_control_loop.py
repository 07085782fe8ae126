"""A control loop: joint velocities at 20 Hz from the Jacobian of the analytic model.

What to look for: the model and the simulated arm use the same URDF, so the tip pose computed from joint positions is equal to the
observed one; a step without images takes well under a millisecond.
"""

from __future__ import annotations

import time

import numpy as np

from rlbench_pin import Discrete, Environment, JointVelocity, MoveArmThenGripper, ObservationConfig
from rlbench_pin.robot import RobotModel, robot_description

GAIN = 2.0  # [1/s]
DAMPING = 0.05
MAX_SPEED = 0.8  # [rad/s]


def main() -> None:
    """Servo the tip to the target of reach_target."""
    config = ObservationConfig()
    config.set_all_high_dim(False)
    model = RobotModel(robot_description("panda"))
    with Environment(MoveArmThenGripper(JointVelocity(), Discrete()), obs_config=config) as env:
        task = env.get_task("reach_target")
        descriptions, obs = task.reset(seed=2)
        target = task.world.body("target").position
        print(descriptions[0])
        began, steps, terminate = time.perf_counter(), 0, False
        while not terminate and steps < 400:
            q = obs.joint_positions
            error = target - model.tip_pose(q)[:3]
            jacobian = model.jacobian(q)[:3]
            # v = J' (J J' + damping^2 I)^-1 gain * error
            v = jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + DAMPING**2 * np.eye(3), GAIN * error)
            v *= min(1.0, MAX_SPEED / max(np.abs(v).max(), 1e-9))
            obs, reward, terminate = task.step(np.append(v, 1.0))
            steps += 1
        took = time.perf_counter() - began
        gap = np.linalg.norm(target - obs.gripper_pose[:3])
        print(f"reward {reward} after {steps} steps, {1000 * gap:.0f} mm from the target")
        print(f"{steps / took:.0f} steps per second, {steps * task.world.control_dt / took:.0f} times real time")


if __name__ == "__main__":
    main()
