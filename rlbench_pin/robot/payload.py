"""What held bodies weigh, from their model files."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pinocchio as pin

from rlbench_pin.robot.geometry import to_placement
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.snapshot import NO_FILE, BodySnapshot, WorldSnapshot
from rlbench_pin.spatial import FloatArray, pose_to_se3
from rlbench_pin.urdf import read_urdf
from rlbench_pin.values import as_record


def payload_inertia(model: RobotModel, snapshot: WorldSnapshot) -> pin.Inertia:
    """Return the inertia of all held bodies in the frame of the last arm joint; those fixed to the world count nothing."""
    as_record(model, RobotModel, "model")
    as_record(snapshot, WorldSnapshot, "snapshot")
    total = pin.Inertia.Zero()
    held = [body for body in snapshot.bodies if body.name in snapshot.attached and not body.fixed]
    if held:
        pin.forwardKinematics(model.arm, model.data, np.asarray(snapshot.arm, dtype=float))
        T_joint_world = model.data.oMi[model.size].inverse()
        for body in held:
            total += T_joint_world.act(_body_inertia(body))
    return total


def _body_inertia(body: BodySnapshot) -> pin.Inertia:
    """Return the inertia of one body in the world."""
    total = pin.Inertia.Zero()
    links = {} if body.urdf == NO_FILE else _link_inertias(body.urdf)
    for name, pose in zip(body.link_names, body.link_poses, strict=True):
        if name in links:
            total += pose_to_se3(pose).act(links[name])
    return total


@cache
def _link_inertias(urdf: Path) -> dict[str, pin.Inertia]:
    """Return the inertia of each link in its link frame; links without a mass are left out."""
    found: dict[str, pin.Inertia] = {}
    for link in read_urdf(urdf).links:
        if link.inertial is not None and link.inertial.mass > 0.0:
            inertia = pin.Inertia(link.inertial.mass, np.zeros(3), _tensor(link.inertial.inertia))
            found[link.name] = to_placement(link.inertial.origin).act(inertia)
    return found


def _tensor(moments: tuple[float, ...]) -> FloatArray:
    """Return the symmetric matrix (3, 3) of ixx, ixy, ixz, iyy, iyz, izz."""
    xx, xy, xz, yy, yz, zz = moments
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
