"""Points of a scene from pictures: those of the given cameras, above the table, without the arm."""

from __future__ import annotations

import numpy as np

from rlbench_pin.evaluation.baselines.few_shot.registration import COLOUR
from rlbench_pin.observation import Observation
from rlbench_pin.spatial import TABLE_HEIGHT

CAMERAS = ("left_shoulder", "right_shoulder", "overhead", "front")
"""Cameras whose pictures are used."""
LOW, HIGH = np.array([-0.12, -0.7, TABLE_HEIGHT + 0.006]), np.array([0.85, 0.7, TABLE_HEIGHT + 0.9])
"""Corners of the box in which points count [m]."""
ARM, HAND = 0.11, 0.13
"""Points nearer to the line through the joints, or to the tip and above it, are the arm's [m]."""
GRAIN = 0.007
"""Edge of the cubes of which each keeps one point [m]."""


def scene_points(observation: Observation) -> np.ndarray:
    """Return the points of a scene, shape (n, 6), see `registration`.

    Args:
        observation: With `rgb` and `point_cloud` of the cameras, and `joint_poses` in `misc`.
    """
    parts = []
    for camera in CAMERAS:
        places, colours = getattr(observation, f"{camera}_point_cloud"), getattr(observation, f"{camera}_rgb")
        parts.append(np.column_stack([places.reshape(-1, 3), colours.reshape(-1, 3) * (COLOUR / 255.0)]).astype(float))
    points = np.concatenate(parts)
    points = points[((points[:, :3] > LOW) & (points[:, :3] < HIGH)).all(axis=1)]
    points = points[_arm_distances(points[:, :3], observation) > 0.0]
    _, kept = np.unique(np.floor(points[:, :3] / GRAIN).astype(int), axis=0, return_index=True)
    return points[kept]


def _arm_distances(points: np.ndarray, observation: Observation) -> np.ndarray:
    """Return how far points (n, 3) are outside of the arm, roughly [m]."""
    joints = np.asarray(observation.misc["joint_poses"], dtype=float)[:, :3]
    assert observation.gripper_pose is not None
    tip = np.asarray(observation.gripper_pose, dtype=float)[:3]
    lines = [(a, b, ARM) for a, b in zip(joints, joints[1:]) if np.linalg.norm(b - a) > 1e-6]
    lines.append((joints[-1], tip, HAND))
    return np.min([_line_distances(points, a, b) - radius for a, b, radius in lines], axis=0)


def _line_distances(points: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    along = np.clip(((points - a) @ (b - a)) / ((b - a) @ (b - a)), 0.0, 1.0)
    return np.asarray(np.linalg.norm(points - (a + along[:, None] * (b - a)), axis=1))
