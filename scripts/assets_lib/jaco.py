"""The Kinova Jaco (j2s6s200): light meshes and small hulls derived from the files of example-robot-data (BSD), with our gripper.

Kinematics, limits and inertias are those of the source, the maker's `kinova_description`: 36 degrees/s for the first three
joints, 48 degrees/s for the wrist, and 40, 80, 40, 20, 20, 20 N m. Joints 1, 4 and 6 are continuous. Its original gripper, whose
fingers do not move in the source, is omitted: a short adapter carries the gripper of `gripper.py` instead.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np

from assets_lib.arm_appearance import light_appearances
from assets_lib.arms import Arm, ArmJoint, ArmLink, drawn, hull_shape, read_inertial, read_joint, write_arm
from assets_lib.dae import Rgb, read_dae
from assets_lib.gripper import COLORS as GRIPPER_COLORS
from assets_lib.gripper import FLANGE_RADIUS, gripper
from assets_lib.licences import bsd_3
from assets_lib.mesh import FloatArray, Mesh, lathe, mass_properties
from assets_lib.source_meshes import example_folder
from assets_lib.urdf import Vec3

SOURCE = "j2s6s200_"
COLORS: dict[str, Rgb] = {**GRIPPER_COLORS, "carbon": (0.24, 0.24, 0.26), "ring": (0.66, 0.67, 0.69)}
MESHES = {
    "link_base": ("base",),
    "link_1": ("shoulder", "ring_big"),
    "link_2": ("arm", "ring_big"),
    "link_3": ("forearm", "ring_big"),
    "link_4": ("wrist_spherical_1", "ring_small"),
    "link_5": ("wrist_spherical_2", "ring_small"),
    "link_6": ("ring_small",),
}
"""Links -> their meshes: carbon fibre first, but for the last one, and a ring at the joint."""
TRIANGLES = 3900
WEIGHTS = {"link_base": 0.7, "link_6": 1.0}
HEADING: Vec3 = (0.0, 0.0, math.pi)
"""How the foot is turned in the frame of the base [rad]."""
ADAPTER_HEIGHT, ADAPTER_MASS = 0.022, 0.1
"""Between the last joint and the gripper [m], [kg]."""


def build_jaco(assets: Path) -> None:
    """Write the robot's URDF, SRDF, meshes and licence below `assets`."""
    source = example_folder("kinova_description")
    root = ET.parse(source / "robots/kinova.urdf").getroot()
    parts = {part: _painted(source, part) for part in MESHES}
    adapter = _adapter()
    looks = [*light_appearances(parts, WEIGHTS, TRIANGLES), *drawn("link_6", [(COLORS["carbon"], adapter)])]
    hulls = {part: np.concatenate([mesh.vertices for _, mesh in own]) for part, own in parts.items()}
    hulls["link_6"] = np.concatenate([hulls["link_6"], adapter.vertices])
    hand = gripper("jaco", "jaco_link_6", (0.0, 0.0, -ADAPTER_HEIGHT), (0.0, math.pi, 0.0))
    write_arm(
        Arm(
            "jaco",
            "Kinova j2s6s200 from the package example-robot-data (BSD-3-Clause, see LICENSE), gripper of ours (MIT).",
            bsd_3("2017, Kinova Robotics inc."),
            (*_links(root, adapter), *hand.links),
            (*_joints(root), *hand.joints),
            (*looks, *hand.looks),
            COLORS,
            hulls | hand.hulls,
        ),
        assets,
    )


def _painted(source: Path, part: str) -> list[tuple[Rgb, Mesh]]:
    """Return the coloured meshes of a part; those of the base are turned into its frame."""
    pieces = []
    for name in MESHES[part]:
        color = COLORS["ring" if name.startswith("ring") else "carbon"]
        turn = HEADING if part == "link_base" else (0.0, 0.0, 0.0)
        pieces += [(color, mesh.moved(rpy=turn)) for _, mesh in read_dae(source / f"meshes/{name}.dae")]
    return pieces


def _adapter() -> Mesh:
    """Draw what stands on the last joint, towards -z: a short cylinder that ends at the flange of the gripper."""
    radius, height = FLANGE_RADIUS, ADAPTER_HEIGHT
    outline = [(0.0, -height), (radius, -height), (radius, -0.002), (radius - 0.002, 0.0), (0.0, 0.0)]
    return lathe(outline, 28)


def _links(root: ET.Element, adapter: Mesh) -> list[ArmLink]:
    links = []
    for part in MESHES:
        element = root.find(f"link[@name='{SOURCE}{part}']")
        assert element is not None
        mass, center, inertia = read_inertial(element)
        if part == "link_6":
            mass, center, inertia = _inertial(adapter, ADAPTER_MASS)
        name = "jaco_base" if part == "link_base" else f"jaco_{part}"
        links.append(ArmLink(name, mass, center, inertia, part, collisions=(hull_shape(part),)))
    return links


def _inertial(mesh: Mesh, mass: float) -> tuple[float, Vec3, FloatArray]:
    """Return mass, centre and inertia of a body that is even all through."""
    volume, center, moments = mass_properties(mesh)
    x, y, z = np.round(center, 5).tolist()
    return mass, (x, y, z), moments * mass / volume


def _joints(root: ET.Element) -> list[ArmJoint]:
    """Return the joints; the first one stands on the base as the foot does."""
    names = {f"{SOURCE}{part}": "base" if part == "link_base" else part for part in MESHES}
    joints = []
    for i in range(1, 7):
        joint = read_joint(root, f"{SOURCE}joint_{i}", "jaco_", names)
        joints.append(replace(joint, name=f"jaco_joint_{i}"))
    joints[0] = replace(joints[0], rpy=(0.0, math.pi, HEADING[2]))
    return joints
