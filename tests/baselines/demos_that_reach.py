"""Made-up demonstrations in which the arm glides to where the task state says."""

from __future__ import annotations

import numpy as np

from rlbench_pin.observation import CAMERAS, Demo, Observation
from rlbench_pin.spatial import TABLE_HEIGHT, pose_at

FRAMES = 24
SENTENCES = ("Go to the red ball.", "Reach the ball.")


def gliding_demo(seed: int) -> Demo:
    """Return a demonstration whose last joint positions follow from its task state."""
    state = np.random.default_rng(seed).uniform(-1.0, 1.0, size=3)
    start, goal = np.zeros(7), np.resize(state, 7)
    frames = []
    for index in range(FRAMES):
        part = min(index / (FRAMES - 6), 1.0)
        command = np.append(start + (goal - start) * part, 1.0 if index < FRAMES - 3 else 0.0)
        misc = {"joint_position_action": command, "descriptions": list(SENTENCES)} if index else {"descriptions": list(SENTENCES)}
        frames.append(
            Observation(
                joint_positions=command[:7].copy(),
                joint_velocities=np.full(7, 0.0 if part == 1.0 else 0.5),
                gripper_open=float(command[7]),
                gripper_pose=pose_at((0.2 + 0.1 * state[0] * part, 0.1 * state[1], TABLE_HEIGHT + 0.3), np.pi, 0.0, 0.0),
                task_low_dim_state=state,
                misc=misc,
            )
        )
        frames[-1].ignore_collisions = False
    return Demo(frames, task_name="reach_target", random_seed=seed, instructions=list(SENTENCES), variation_number=0)


def look(middle: np.ndarray, seed: int = 0) -> Observation:
    """Return an observation of five cameras that see a ball of points over a table."""
    rng = np.random.default_rng(seed)
    observation = Observation(
        gripper_pose=pose_at((0.2, 0.0, TABLE_HEIGHT + 0.4), np.pi, 0.0, 0.0),
        gripper_open=1.0,
        joint_positions=np.array([0.0, 0.2, 0.0, -0.9, 0.0, 1.2, 0.0]),
        gripper_joint_positions=np.array([0.04, 0.04]),
    )
    for camera in CAMERAS:
        points = rng.uniform((-0.4, -0.6, TABLE_HEIGHT), (0.8, 0.6, TABLE_HEIGHT), size=(24, 24, 3))
        directions = rng.normal(size=(12, 24, 3))
        points[:12] = middle + 0.05 * directions / np.linalg.norm(directions, axis=-1, keepdims=True)
        colors = np.full((24, 24, 3), 200, np.uint8)
        colors[:12] = (255, 0, 0)
        setattr(observation, f"{camera}_point_cloud", points.astype(np.float32))
        setattr(observation, f"{camera}_rgb", colors)
    return observation
