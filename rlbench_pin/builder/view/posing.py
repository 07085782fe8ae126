"""Poses as people type them: lengths in metres to a tenth of a millimetre, turns in degrees."""

from __future__ import annotations

import math

import numpy as np

from rlbench_pin.spatial import FloatArray, PoseLike, compose, inverse, pose_at, pose_to_matrix

Vector3 = tuple[float, float, float]
_PLACES, _TURNS = 4, 2  # decimals of [m] and of [deg]


def position_of(pose: PoseLike) -> Vector3:
    """Return x, y, z of a pose (7,) [m], rounded."""
    x, y, z = (round(float(v), _PLACES) + 0.0 for v in pose[:3])
    return x, y, z


def turn_of(pose: PoseLike) -> Vector3:
    """Return roll, pitch, yaw of a pose (7,) in degrees, rounded: Rz(yaw) Ry(pitch) Rx(roll)."""
    m = pose_to_matrix(pose)
    across = math.hypot(m[0, 0], m[1, 0])
    pitch = math.atan2(-m[2, 0], across)
    if across > 1e-6:
        angles = math.atan2(m[2, 1], m[2, 2]), pitch, math.atan2(m[1, 0], m[0, 0])
    else:
        angles = math.atan2(-m[1, 2], m[1, 1]), pitch, 0.0
    roll, pitch, yaw = (_half_turn(round(math.degrees(angle), _TURNS)) for angle in angles)
    return roll, pitch, yaw


def pose_of(position: Vector3, turn: Vector3) -> FloatArray:
    """Return the pose (7,) at a position [m] with a turn in degrees, without float dust."""
    roll, pitch, yaw = (math.radians(angle) for angle in turn)
    pose = pose_at(position, roll, pitch, yaw)
    if pose[6] < -1e-12:
        pose[3:] *= -1.0
    return np.round(pose, 12) + 0.0


def tidy(pose: PoseLike) -> FloatArray:
    """Return a pose (7,) whose numbers are those that a person would type."""
    return pose_of(position_of(pose), turn_of(pose))


def in_frame(pose: PoseLike, frame: PoseLike) -> FloatArray:
    """Return a world pose (7,) as seen from a frame (7,), tidied."""
    return tidy(compose(inverse(frame), pose))


def _half_turn(degrees: float) -> float:
    """Return -180 as 180, and no negative zero."""
    return 180.0 if degrees == -180.0 else degrees + 0.0
