"""Poses of bodies, links and frames of a scene file, without physics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.robot.geometry import to_placement
from rlbench_pin.scene import BodySpec, SceneSpec, resolve_asset
from rlbench_pin.scene.spec import ROOT, WORLD, PosedSpec
from rlbench_pin.spatial import IDENTITY, FloatArray, compose, pose_to_se3, se3_to_pose
from rlbench_pin.urdf import Urdf, UrdfJoint, read_urdf


def link_poses(urdf: Urdf, joints: Mapping[str, float], scale: float = 1.0) -> dict[str, FloatArray]:
    """Return the pose (7,) of each link in the frame of the base link; links that no joints connect to it are left out.

    Args:
        urdf: The content of the file.
        joints: Positions of joints by name [rad] or [m]; the default is 0.
        scale: Factor for the lengths of the file.
    """
    poses = {urdf.base_link: IDENTITY.copy()}
    waiting = list(urdf.joints)
    while ready := [joint for joint in waiting if joint.parent in poses]:
        for joint in ready:
            origin = se3_to_pose(to_placement(joint.origin, scale))
            poses[joint.child] = compose(poses[joint.parent], origin, _moved(joint, joints.get(joint.name, 0.0)))
        waiting = [joint for joint in waiting if joint not in ready]
    return poses


def _moved(joint: UrdfJoint, position: float) -> FloatArray:
    """Return the pose (7,) of the child link at a joint position, relative to its pose at position 0."""
    pose, axis = IDENTITY.copy(), np.array(joint.axis)
    axis = axis / max(float(np.linalg.norm(axis)), 1e-12)
    if joint.kind == "prismatic":
        pose[:3] = position * axis
    elif joint.kind in ("revolute", "continuous"):
        pose[3:] = [*(np.sin(0.5 * position) * axis), np.cos(0.5 * position)]
    return pose


@dataclass(frozen=True, eq=False)
class Places:
    """World poses of all elements of a scene file."""

    elements: Mapping[str, FloatArray]
    """Pose (7,) of `root`, `world` and each body, frame, region, sensor and waypoint, by name."""
    links: Mapping[str, FloatArray]
    """Pose (7,) of each link of each body, by `<body>/<link>`."""
    missing: Mapping[str, str] = field(default_factory=dict)
    """Name -> why it has no pose: a file that cannot be read, a parent that does not exist."""

    def of(self, name: str) -> FloatArray | None:
        """Return the pose (7,) of a name or of `<body>/<link>`; None if it has none."""
        return self.elements.get(name, self.links.get(name))


def places_at_rest(spec: SceneSpec, poses: Mapping[str, FloatArray] | None = None) -> Places:
    """Return the poses of a scene before simulation, with the root at its nominal pose and joints at their start positions.

    Args:
        spec: The content of the scene file.
        poses: World poses (7,) by name that replace those of the file; children follow.
    """
    given = poses or {}
    root = given.get(ROOT, se3_to_pose(pose_to_se3(spec.placement.pose)))
    elements: dict[str, FloatArray] = {WORLD: IDENTITY.copy(), ROOT: root}
    links: dict[str, FloatArray] = {}
    missing: dict[str, str] = {}
    waiting: list[PosedSpec] = list(spec.posed())
    while ready := [item for item in waiting if item.parent in elements or item.parent in links]:
        for item in ready:
            parent = elements[item.parent] if item.parent in elements else links[item.parent]
            elements[item.name] = given[item.name] if item.name in given else compose(parent, item.pose)
            if isinstance(item, BodySpec):
                try:
                    in_body = _body_links(spec, item)
                except RlbenchPinError as error:
                    missing[item.name] = str(error)
                else:
                    links |= {f"{item.name}/{link}": compose(elements[item.name], pose) for link, pose in in_body.items()}
        waiting = [item for item in waiting if item.name not in elements]
    missing |= {item.name: f"its parent '{item.parent}' has no place." for item in waiting}
    return Places(elements, links, missing)


def _body_links(spec: SceneSpec, body: BodySpec) -> dict[str, FloatArray]:
    """Return the pose (7,) of each link of a body in the frame of the body."""
    joints = {j.name.partition("/")[2]: j.position for j in spec.joint if j.name.partition("/")[0] == body.name}
    return link_poses(read_urdf(resolve_asset(spec, body.asset), f"body '{body.name}'"), joints, body.scale)
