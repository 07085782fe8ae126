"""Where the links of a URDF file are at given joint positions."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from rlbench_pin.spatial import IDENTITY, FloatArray, compose, pose_at
from rlbench_pin.urdf import Urdf, UrdfJoint, UrdfOrigin


def link_poses(urdf: Urdf, joints: Mapping[str, float], scale: float = 1.0) -> dict[str, FloatArray]:
    """Return the pose (7,) of each link in the frame of the base link; links that no joint ties to it are left out.

    Args:
        urdf: What the file says.
        joints: Position by name of a joint [rad] or [m]; those that are not named are at 0.
        scale: Factor on the lengths of the file.
    """
    poses = {urdf.base_link: IDENTITY.copy()}
    waiting = list(urdf.joints)
    while ready := [joint for joint in waiting if joint.parent in poses]:
        for joint in ready:
            origin = origin_pose(joint.origin, scale)
            poses[joint.child] = compose(poses[joint.parent], origin, _moved(joint, joints.get(joint.name, 0.0)))
        waiting = [joint for joint in waiting if joint not in ready]
    return poses


def origin_pose(origin: UrdfOrigin | None, scale: float = 1.0) -> FloatArray:
    """Return an origin of a URDF file as a pose (7,), its lengths multiplied by `scale`."""
    return IDENTITY.copy() if origin is None else pose_at([scale * x for x in origin.xyz], *origin.rpy)


def _moved(joint: UrdfJoint, position: float) -> FloatArray:
    """Return by what (7,) a joint moves its child in the frame that the child has at position 0."""
    pose, axis = IDENTITY.copy(), np.array(joint.axis)
    axis = axis / max(float(np.linalg.norm(axis)), 1e-12)
    if joint.kind == "prismatic":
        pose[:3] = position * axis
    elif joint.kind in ("revolute", "continuous"):
        pose[3:] = [*(np.sin(0.5 * position) * axis), np.cos(0.5 * position)]
    return pose
