"""The Universal Robots UR5e with a Robotiq 2F-85: light meshes and small hulls derived from the files of airo-models (MIT).

Kinematics and limits are those of the source, which are the maker's: +-360 degrees (elbow +-180), 180 degrees/s, and 150 N m for
the three joints of size 3, 28 N m for those of size 1 (Universal Robots, UR5e technical details and "Max. joint torques").
Masses, centres of mass and inertias are the maker's, too (Universal Robots, "DH parameters for calculations of kinematics and
dynamics"). Those of the gripper's links are from the source; the body's mass makes the whole gripper 0.9 kg. It closes 85 mm
within 0.57 s at 150 mm/s and presses with at most 235 N (Robotiq, 2F-85 instruction manual, specifications).
"""

from __future__ import annotations

import importlib.util
import math
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

from assets_lib.arm_appearance import Appearance, light_appearances
from assets_lib.arms import (
    Arm,
    ArmJoint,
    ArmLink,
    SourceMissing,
    drawn,
    frame,
    hull_shape,
    read_inertial,
    read_joint,
    read_vector,
    symmetric,
    turned,
    write_arm,
)
from assets_lib.dae import Rgb
from assets_lib.mesh import FloatArray, Mesh, box
from assets_lib.source_meshes import read_obj
from assets_lib.urdf import Vec3, box_shape

PREFIX = "ur5e_"
COLORS: dict[str, Rgb] = {
    "light": (0.80, 0.81, 0.82),
    "gray": (0.55, 0.56, 0.58),
    "blue": (0.42, 0.63, 0.78),
    "dark": (0.13, 0.13, 0.14),
    "black": (0.06, 0.06, 0.065),
}
PAINTS = {"Black": COLORS["dark"], "JointGrey": COLORS["gray"], "LinkGrey": COLORS["light"], "URBlue": COLORS["blue"]}
"""Our colours of the materials of the source."""
ARM_TRIANGLES, GRIPPER_TRIANGLES = 3400, 980
WEIGHTS = {"base": 1.0, "wrist3": 1.5}
GRIPPER_WEIGHTS = {"hand": 2.0, "outer_knuckle": 2.0, "inner_knuckle": 2.0, "inner_finger": 3.0}

LINKS: dict[str, tuple[str, tuple[str, ...]]] = {
    "base_link_inertia": ("base", ("base",)),
    "shoulder_link": ("shoulder", ("shoulder",)),
    "upper_arm_link": ("upperarm", tuple(f"upper_arm_link_part_{i}" for i in range(3))),
    "forearm_link": ("forearm", tuple(f"forearm_link_part_{i}" for i in range(3))),
    "wrist_1_link": ("wrist1", ("wrist1",)),
    "wrist_2_link": ("wrist2", ("wrist2",)),
    "wrist_3_link": ("wrist3", ("wrist3",)),
}
"""Links of the source -> their visual mesh, and their collision meshes."""
JOINTS = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
RIGHT = math.pi / 2.0
MASSES: dict[str, tuple[float, Vec3, FloatArray]] = {
    "base_link_inertia": (4.0, (0.0, 0.0, 0.025), symmetric(0.00443, 0.00443, 0.0072)),
    "shoulder_link": (
        3.761,
        (0.0, -0.00193, -0.02561),
        turned(symmetric(0.0070021, 0.00648091, 0.00657286, 7.3e-7, -1.053e-5, 0.00049994), (RIGHT, 0.0, 0.0)),
    ),
    "upper_arm_link": (
        8.058,
        (-0.2125, 0.0, 0.11336),
        symmetric(0.01505885, 0.33388086, 0.33247207, -5.4e-5, 5.63e-6, -1.81e-6),
    ),
    "forearm_link": (
        2.846,
        (-0.2422, 0.0, 0.0265),
        symmetric(0.00399632, 0.07879254, 0.0784851, -1.365e-5, 0.00137272, -6.6e-6),
    ),
    "wrist_1_link": (
        1.37,
        (0.0, -0.01634, -0.0018),
        turned(symmetric(0.00165491, 0.00135962, 0.00126279, -2.82e-6, -4.38e-6, 0.00010157), (RIGHT, 0.0, 0.0)),
    ),
    "wrist_2_link": (
        1.3,
        (0.0, 0.01634, -0.0018),
        turned(symmetric(0.00135617, 0.00127827, 0.00096614, -2.74e-6, 4.44e-6, -5.048e-5), (-RIGHT, 0.0, 0.0)),
    ),
    "wrist_3_link": (0.365, (0.0, 0.0, -0.001159), symmetric(0.00018694, 0.00018908, 0.00025756, 6e-8, -1.7e-7, -9.2e-7)),
}
"""Mass [kg], centre [m] and inertia of each link; those of the base are estimates."""

COUPLING = 0.0139
"""Height of the coupling between flange and gripper [m]."""
GRIPPER_MASS = 0.9
"""With fingers and coupling [kg]."""
SHUT, GRIPPER_SPEED, GRIPPER_TORQUE = 0.8, 1.4, 13.4
"""Angle of the shut gripper [rad]; its speed [rad/s]; the torque of 235 N at 57 mm [N m]."""
SLACK = 0.02
"""How much farther the joints may go that follow [rad]."""
GRIPPER_DAMPING = 0.001
"""[N m s/rad]"""
PAD_WIDTH, PAD_LOW, PAD_HIGH, PAD_BACK = 0.022, 0.01367, 0.05117, -0.01885
"""The pad in the frame of the inner finger: size along x, least and largest z, and y of its back [m]."""
PAD_MASS = 0.006
"""[kg]"""
NEARLY_SHUT, TIP_TO_END = 0.7, 0.0095
"""At this angle [rad] the pads end so far beyond the tip frame [m], as those of the Panda do."""


def airo_folder(given: Path | None = None) -> Path:
    """Return the folder `airo_models` of the package airo-models, below a given folder or where it is installed.

    Raises:
        SourceMissing: It is not there.
    """
    if given is not None:
        for folder in (given, given / "airo_models"):
            if (folder / "arms/ur5e/ur5e.urdf").is_file():
                return folder
        raise SourceMissing(
            f"There is no airo_models/arms/ur5e/ur5e.urdf in {given}. Get it: `pip download airo-models --no-deps`."
        )
    spec = importlib.util.find_spec("airo_models")
    if spec is None or spec.origin is None:
        raise SourceMissing(
            "The files of airo-models 0.0.12 are missing. Install it, or unpack its wheel and pass --airo FOLDER."
        )
    return Path(spec.origin).parent


def build_ur5e(assets: Path, airo: Path | None = None) -> None:
    """Write the robot's URDF, SRDF, meshes and licence below `assets`; `airo` is where the wheel of airo-models is unpacked."""
    source = airo_folder(airo)
    arm, gripper = source / "arms/ur5e", source / "grippers/robotiq_2f_85"
    root = _read_urdf(arm / "ur5e.urdf")
    parts, hulls, links = _arm_links(arm, root)
    joints = [read_joint(root, f"{name}_joint", PREFIX, {"base_link_inertia": "base_link"}) for name in JOINTS]
    joints[0] = ArmJoint(**{**vars(joints[0]), "rpy": (0.0, 0.0, math.pi)})  # the arm reaches along +x at 0
    looks = light_appearances(parts, WEIGHTS, ARM_TRIANGLES)
    gripper_looks, gripper_hulls = _gripper_shapes(gripper / "meshes")
    gripper_root = _read_urdf(gripper / "urdf/robotiq_2f_85.urdf")
    write_arm(
        Arm(
            "ur5e",
            "UR5e and Robotiq 2F-85 from the package airo-models (MIT, see LICENSE).",
            _licence(source),
            (*links, *_gripper_links(gripper_root)),
            (*joints, *_gripper_joints(gripper_root)),
            (*looks, *gripper_looks),
            COLORS,
            hulls | gripper_hulls,
        ),
        assets,
    )


def _licence(source: Path) -> str:
    """Return the licence of the package, which lies in the folder of its metadata."""
    found = sorted(source.parent.glob("airo_models-*.dist-info/**/LICENSE"))
    if not found:
        raise SourceMissing(f"There is no airo_models-*.dist-info with a LICENSE in {source.parent}.")
    return found[0].read_text()


def _read_urdf(path: Path) -> ET.Element:
    """Read a URDF that uses a prefix without saying what it means."""
    return ET.fromstring(re.sub(r"\bdrake:", "", path.read_text()))


def _arm_links(source: Path, root: ET.Element) -> tuple[dict[str, list[tuple[Rgb, Mesh]]], dict[str, FloatArray], list[ArmLink]]:
    """Return visual parts, points of the hulls, and links of the arm."""
    parts: dict[str, list[tuple[Rgb, Mesh]]] = {}
    hulls: dict[str, FloatArray] = {}
    links = []
    for name, (part, solids) in LINKS.items():
        element = root.find(f"link[@name='{name}']")
        assert element is not None
        origin = element.find("visual/origin")
        xyz, rpy = read_vector(origin, "xyz"), read_vector(origin, "rpy")
        if part == "base":
            rpy = (0.0, 0.0, 0.0)  # its link is turned half round in the source
        parts[part] = [(c, m.moved(xyz, rpy)) for c, m in read_obj(source / f"visual/{part}.obj", PAINTS)]
        own = [part if len(solids) == 1 else f"{part}_{i}" for i in range(len(solids))]
        for hull, solid in zip(own, solids, strict=True):
            hulls[hull] = read_obj(source / f"collision/{solid}.obj")[0][1].moved(xyz, rpy).vertices
        shapes = tuple(hull_shape(hull) for hull in own)
        links.append(ArmLink(PREFIX + name.removesuffix("_inertia"), *MASSES[name], part, collisions=shapes))
    return parts, hulls, links


# The gripper ------------------------------------------------------------------------------------------------------


def _gripper_shapes(meshes: Path) -> tuple[list[Appearance], dict[str, FloatArray]]:
    """Return what is seen of the gripper, and the points of its hulls."""
    coupling = read_obj(meshes / "visual/robotiq_gripper_coupling.obj", scale=0.001)[0][1].moved((0.0, 0.0, -0.0069))
    body = read_obj(meshes / "visual/robotiq_arg2f_85_base_link.obj")[0][1]
    knuckle, inner, finger = (_bar(meshes, name) for name in ("outer_knuckle", "inner_knuckle", "inner_finger"))
    outer = _bar(meshes, "outer_finger").moved(OUTER_FINGER)
    parts = {
        "hand": [(COLORS["dark"], body), (COLORS["gray"], coupling)],
        "outer_knuckle": [(COLORS["gray"], knuckle), (COLORS["dark"], outer)],
        "inner_knuckle": [(COLORS["dark"], inner)],
        "inner_finger": [(COLORS["gray"], finger)],
    }
    looks = light_appearances(parts, GRIPPER_WEIGHTS, GRIPPER_TRIANGLES)
    size, center = _pad()
    looks += drawn("inner_finger", [(COLORS["black"], box(size, center))])
    hulls = {
        "hand": np.concatenate([body.vertices, coupling.vertices]),
        "outer_knuckle": knuckle.vertices,
        "outer_finger": outer.vertices,
        "inner_knuckle": inner.vertices,
        "inner_finger": finger.vertices,
    }
    return looks, hulls


def _bar(meshes: Path, name: str) -> Mesh:
    return read_obj(meshes / f"visual/robotiq_arg2f_85_{name}.obj", scale=0.001)[0][1]


OUTER_FINGER: Vec3 = (0.0, 0.0315, -0.0041)
"""Where the outer finger is fixed to its knuckle [m]."""
PIVOT: Vec3 = (0.0, 0.0376, 0.043)
"""Where the inner finger turns on it [m]."""
KNUCKLE: Vec3 = (0.0, 0.0306011, 0.054904)
"""Where the right outer knuckle turns on the body [m]."""


def _pivot_at(angle: float) -> tuple[float, float]:
    """Return y and z of the pivot of the inner finger from that of its knuckle [m]."""
    _, y, z = PIVOT
    return y * math.cos(angle) - z * math.sin(angle), y * math.sin(angle) + z * math.cos(angle)


def _pad() -> tuple[Vec3, Vec3]:
    """Return size and centre of the pad in the frame of the inner finger; both pads touch when the gripper is shut."""
    face = -(KNUCKLE[1] + _pivot_at(SHUT)[0])
    size = (PAD_WIDTH, round(PAD_BACK - face, 5), round(PAD_HIGH - PAD_LOW, 5))
    return size, (0.0, round((PAD_BACK + face) / 2.0, 6), round((PAD_HIGH + PAD_LOW) / 2.0, 5))


def _tip() -> Vec3:
    """Return the tip in the frame of the hand."""
    return (0.0, 0.0, round(KNUCKLE[2] + _pivot_at(NEARLY_SHUT)[1] + PAD_HIGH - TIP_TO_END, 4))


def _gripper_links(root: ET.Element) -> list[ArmLink]:
    """Return the body and the six moving links: outer finger and pad belong to the link that carries them."""
    read = {link.attrib["name"]: link for link in root.iterfind("link")}
    outer = _joined(read_inertial(read["left_outer_knuckle"]), _shifted(read_inertial(read["left_outer_finger"]), OUTER_FINGER))
    size, center = _pad()
    squares = np.square(size)
    pad = (PAD_MASS, center, np.diag(PAD_MASS / 12.0 * (squares.sum() - squares)))
    inner = _joined(read_inertial(read["left_inner_finger"]), pad)
    knuckle = read_inertial(read["left_inner_knuckle"])
    mass, middle, inertia = read_inertial(read["base_link_inertia"])
    own = GRIPPER_MASS - 2.0 * (outer[0] + inner[0] + knuckle[0])
    links = [ArmLink(PREFIX + "hand", own, middle, inertia * own / mass, "hand", collisions=(hull_shape("hand"),))]
    for side in ("left", "right"):
        both = (hull_shape("outer_knuckle"), hull_shape("outer_finger"))
        touching = (box_shape(size, center), hull_shape("inner_finger"))
        links += [
            ArmLink(f"{PREFIX}{side}_outer_knuckle", *outer, "outer_knuckle", collisions=both),
            ArmLink(f"{PREFIX}{side}_inner_finger", *inner, "inner_finger", collisions=touching, finger=True),
            ArmLink(f"{PREFIX}{side}_inner_knuckle", *knuckle, "inner_knuckle", collisions=(hull_shape("inner_knuckle"),)),
        ]
    return [*links, frame(PREFIX + "tip")]


def _gripper_joints(root: ET.Element) -> list[ArmJoint]:
    """Return mount and tip, and the linkage: each outer knuckle is driven, the other joints of its side follow it."""
    mount = ArmJoint(
        PREFIX + "hand_joint", "fixed", PREFIX + "wrist_3_link", PREFIX + "hand", (0.0, 0.0, COUPLING), (0.0, 0.0, RIGHT)
    )
    joints = [mount, ArmJoint(PREFIX + "tip_joint", "fixed", PREFIX + "hand", PREFIX + "tip", _tip())]
    for side, drive in (("left", "finger_joint"), ("right", "right_outer_knuckle_joint")):
        names = {"base_link_inertia": "hand", f"{side}_outer_finger": f"{side}_outer_knuckle"}
        for name, ratio in ((drive, 0), (f"{side}_inner_finger_joint", -1), (f"{side}_inner_knuckle_joint", 1)):
            joint = read_joint(root, name, PREFIX, names)
            changes = {
                "xyz": PIVOT if ratio < 0 else joint.xyz,
                "lower": -(SHUT + SLACK) if ratio < 0 else 0.0,
                "upper": 0.0 if ratio < 0 else SHUT + SLACK * ratio,
                "velocity": GRIPPER_SPEED,
                "effort": GRIPPER_TORQUE,
                "damping": GRIPPER_DAMPING,
                "mimic": (PREFIX + drive, float(ratio)) if ratio else None,
            }
            joints.append(ArmJoint(**{**vars(joint), **changes}))
    return joints


Inertial = tuple[float, Vec3, FloatArray]


def _shifted(inertial: Inertial, by: Vec3) -> Inertial:
    mass, (x, y, z), inertia = inertial
    return mass, (x + by[0], y + by[1], z + by[2]), inertia


def _joined(*parts: Inertial) -> Inertial:
    """Return mass, centre and inertia of several bodies that are one."""
    mass = sum(part[0] for part in parts)
    center = sum(part[0] * np.array(part[1]) for part in parts) / mass
    inertia = np.zeros((3, 3))
    for own, middle, tensor in parts:
        away = np.array(middle) - center
        inertia += tensor + own * (away @ away * np.eye(3) - np.outer(away, away))
    x, y, z = center.tolist()
    return mass, (x, y, z), inertia
