"""What held bodies weigh, from their model files."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from functools import cache
from pathlib import Path

import numpy as np
import pinocchio as pin

from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.snapshot import NO_FILE, BodySnapshot, WorldSnapshot
from rlbench_pin.spatial import FloatArray, pose_to_se3


def payload_inertia(model: RobotModel, snapshot: WorldSnapshot) -> pin.Inertia:
    """Return the inertia of all held bodies in the frame of the last arm joint; those fixed to the world count nothing."""
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
    for link in ET.parse(urdf).getroot().iterfind("link"):
        mass = link.find("inertial/mass")
        if mass is None or float(mass.get("value", 0)) <= 0.0:
            continue
        inertia = pin.Inertia(float(mass.get("value", 0)), np.zeros(3), _tensor(link.find("inertial/inertia")))
        found[str(link.get("name"))] = _placement(link.find("inertial/origin")).act(inertia)
    return found


def _tensor(element: ET.Element | None) -> FloatArray:
    tensor = np.zeros((3, 3))
    for i, a in enumerate("xyz"):
        for j, b in enumerate("xyz"):
            key = f"i{min(a, b)}{max(a, b)}"
            tensor[i, j] = 0.0 if element is None else float(element.get(key, 0))
    return tensor


def _placement(origin: ET.Element | None) -> pin.SE3:
    if origin is None:
        return pin.SE3.Identity()
    rpy, xyz = ([float(word) for word in origin.get(key, "0 0 0").split()] for key in ("rpy", "xyz"))
    return pin.SE3(pin.rpy.rpyToMatrix(*rpy), np.array(xyz))
