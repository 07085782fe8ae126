"""The UFACTORY xArm7: light meshes and small hulls derived from the files of example-robot-data (BSD-3), with our gripper.

Kinematics, limits and inertias are those of the source, the maker's `xarm_ros2`: 180 degrees/s for all joints (xArm user manual,
"Technical specifications"), and 50, 50, 30, 30, 30, 20, 20 N m.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

from assets_lib.arm_appearance import light_appearances
from assets_lib.arms import Arm, ArmLink, hull_shape, read_inertial, read_joint, write_arm
from assets_lib.dae import Rgb
from assets_lib.gripper import COLORS as GRIPPER_COLORS
from assets_lib.gripper import gripper
from assets_lib.licences import bsd_3
from assets_lib.mesh import Mesh
from assets_lib.source_meshes import example_folder, read_stl

PREFIX = "xarm7_"
COLORS: dict[str, Rgb] = {**GRIPPER_COLORS, "white": (0.93, 0.935, 0.94)}
PARTS = ("link_base", *(f"link{i}" for i in range(1, 8)))
TRIANGLES = 4000
WEIGHTS = {"link_base": 0.5, "link7": 0.5}
RINGS = {
    "link_base": (-0.01, 0.0115, 1.0),
    "link1": (-0.113, -0.102, 0.06),
    "link2": (0.074, 0.085, 0.055),
    "link3": (-0.102, -0.091, 0.06),
    "link4": (0.066, 0.077, 0.055),
    "link5": (-0.174, -0.163, 0.06),
    "link6": (-0.005, 0.006, 0.045),
    "link7": (-1.0, 1.0, 1.0),
}
"""What is grey of each part: least and largest z, and the distance from the z axis [m]."""


def build_xarm7(assets: Path) -> None:
    """Write the robot's URDF, SRDF, meshes and licence below `assets`."""
    source = example_folder("xarm_description")
    root = ET.parse(source / "urdf/xarm7.urdf").getroot()
    meshes = {part: read_stl(source / f"meshes/xarm7/visual/{part}.stl") for part in PARTS}
    read = {link.attrib["name"]: link for link in root.iterfind("link")}
    links = [ArmLink(PREFIX + part, *read_inertial(read[part]), part, collisions=(hull_shape(part),)) for part in PARTS]
    joints = [read_joint(root, f"joint{i}", PREFIX) for i in range(1, 8)]
    hand = gripper("xarm7", f"{PREFIX}link7")
    write_arm(
        Arm(
            "xarm7",
            "xArm7 from the package example-robot-data (BSD-3-Clause, see LICENSE), gripper of ours (MIT).",
            bsd_3("2021, UFACTORY, Inc."),
            (*links, *hand.links),
            (*joints, *hand.joints),
            (*light_appearances({part: _painted(part, mesh) for part, mesh in meshes.items()}, WEIGHTS, TRIANGLES), *hand.looks),
            COLORS,
            {part: mesh.vertices for part, mesh in meshes.items()} | hand.hulls,
        ),
        assets,
    )


def _painted(part: str, mesh: Mesh) -> list[tuple[Rgb, Mesh]]:
    """Return the pieces of a part: white, but for its grey rings."""
    low, high, radius = RINGS[part]
    for height in (low, high):
        mesh = _cut(mesh, height)
    middle = mesh.vertices[mesh.faces].mean(axis=1)
    ring = (middle[:, 2] > low) & (middle[:, 2] < high) & (np.hypot(middle[:, 0], middle[:, 1]) < radius)
    pieces = ((COLORS["white"], mesh.faces[~ring]), (COLORS["metal"], mesh.faces[ring]))
    return [(color, Mesh(mesh.vertices, faces)) for color, faces in pieces if len(faces)]


def _cut(mesh: Mesh, height: float) -> Mesh:
    """Return a mesh whose triangles end at the plane z = `height`."""
    points, faces = mesh.vertices, mesh.faces
    z = points[:, 2] - height
    above = z[faces] > 0.0
    whole = above.all(axis=1) | ~above.any(axis=1)
    cut, alone = faces[~whole], above[~whole]
    odd = np.where(alone.sum(axis=1) == 1, alone.argmax(axis=1), (~alone).argmax(axis=1))
    a, b, c = (cut[np.arange(len(cut)), (odd + i) % 3] for i in range(3))
    new = [points[a] + (z[a] / (z[a] - z[other]))[:, None] * (points[other] - points[a]) for other in (b, c)]
    ab = len(points) + np.arange(len(cut))
    ca = ab + len(cut)
    pieces = [faces[whole], np.column_stack([a, ab, ca]), np.column_stack([ab, b, c]), np.column_stack([ab, c, ca])]
    return Mesh(np.concatenate([points, *new]), np.concatenate(pieces))
