"""Records of arms, and functions for all arms that write URDF, SRDF and OBJ files."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from assets_lib.arm_appearance import Appearance, Piece
from assets_lib.dae import Rgb
from assets_lib.decimate import small_hull
from assets_lib.files import number, numbers, obj_text, significant, write_text
from assets_lib.mesh import FloatArray, Mesh, corner_normals, merge, rotation
from assets_lib.urdf import ZERO, Shape, Vec3
from rlbench_pin.robot.self_collisions import srdf_text

HULL_VERTICES = 64
"""Most vertices of a collision hull."""
ARM_DAMPING = 0.003
"""Of the joints of all arms, as in the Panda's file [N m s/rad]."""
CREASE = 0.8
"""Angle below which faces of drawn parts are shaded smoothly [rad]."""


class SourceMissing(Exception):
    """The files from which an arm is made are not there."""


@dataclass(frozen=True)
class ArmLink:
    """One link of an arm."""

    name: str
    mass: float
    """[kg]"""
    center: Vec3
    """Centre of mass [m]."""
    inertia: FloatArray
    """About the centre, shape (3, 3) [kg m^2]."""
    part: str | None = None
    """Its visual part, whose meshes several links may share; None is not seen."""
    visual_rpy: Vec3 = ZERO
    """How the visual part is turned [rad]."""
    collisions: tuple[Shape, ...] = ()
    """Boxes, and meshes that are named after hulls."""
    finger: bool = False
    """Whether it has the friction of a finger."""


@dataclass(frozen=True)
class ArmJoint:
    """How a link of an arm moves on its parent."""

    name: str
    kind: Literal["revolute", "continuous", "prismatic", "fixed"]
    parent: str
    child: str
    xyz: Vec3 = ZERO
    rpy: Vec3 = ZERO
    axis: Vec3 = (0.0, 0.0, 1.0)
    lower: float = 0.0
    upper: float = 0.0
    effort: float = 0.0
    """Largest torque or force [N m] or [N]."""
    velocity: float = 0.0
    """Largest speed [rad/s] or [m/s]."""
    damping: float = 0.0
    mimic: tuple[str, float] | None = None
    """The joint that it follows, and how many times as far it goes."""


@dataclass(frozen=True)
class Arm:
    """One arm with its gripper, ready to be written."""

    name: str
    source: str
    """Where it comes from, for the head of the URDF."""
    licence: str
    """Text of the file LICENSE."""
    links: tuple[ArmLink, ...]
    joints: tuple[ArmJoint, ...]
    looks: tuple[Appearance, ...]
    """What is seen of all parts."""
    colors: Mapping[str, Rgb]
    """Names of the colours of the looks."""
    hulls: Mapping[str, FloatArray] = field(default_factory=dict)
    """Points (n, 3) [m] of each collision hull."""


def write_arm(arm: Arm, assets: Path) -> None:
    """Write an arm's URDF, SRDF, meshes and licence below `assets`."""
    target = assets / "robots" / arm.name
    visuals = write_visuals(target, arm.looks, arm.colors)
    for name, points in arm.hulls.items():
        write_hull(target, name, points)
    urdf = target / f"{arm.name}.urdf"
    write_text(urdf, _arm_urdf(arm, visuals))
    write_text(target / f"{arm.name}.srdf", srdf_text(urdf))
    write_text(target / "LICENSE", arm.licence)


def write_visuals(
    target: Path, looks: Iterable[Appearance], colors: Mapping[str, Rgb], repaint: Mapping[tuple[str, str], str] | None = None
) -> dict[str, list[tuple[str, Rgb]]]:
    """Write `<part>_<color>.obj` files and return their names and colours for each part.

    Args:
        target: Folder of the arm.
        looks: All pieces of all parts.
        colors: The colours of the arm, by name; a piece gets the nearest one.
        repaint: Other colours for pieces of a part and a colour.
    """
    groups: dict[tuple[str, str], list[Appearance]] = {}
    result: dict[str, list[tuple[str, Rgb]]] = {}
    for look in looks:
        part, name = look.piece.part, _color_name(look.piece.color, colors)
        groups.setdefault((part, (repaint or {}).get((part, name), name)), []).append(look)
        result.setdefault(part, [])
    for (part, name), same in sorted(groups.items()):
        mesh = merge([look.piece.mesh for look in same])
        faces = _has_area(mesh)
        normals = np.concatenate([look.normals for look in same])[faces]
        text = obj_text(Mesh(mesh.vertices, mesh.faces[faces]), crease=CREASE, normals=normals)
        write_text(target / f"meshes/visual/{part}_{name}.obj", text)
        result[part].append((f"{part}_{name}", colors[name]))
    return result


def _has_area(mesh: Mesh) -> NDArray[np.bool_]:
    """Return which faces still have an area, and so a normal, with the rounded vertices of an OBJ file, (m,)."""
    a, b, c = (np.round(mesh.vertices, 5)[mesh.faces[:, k]] for k in range(3))
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1) > 0.0)


def write_hull(target: Path, name: str, points: FloatArray) -> None:
    """Write the collision mesh `name` of an arm: a hull of at most 64 vertices around points (n, 3)."""
    hull = small_hull(points, HULL_VERTICES)
    write_text(target / f"meshes/collision/{name}.obj", obj_text(hull, crease=None))


def drawn(part: str, pieces: Sequence[tuple[Rgb, Mesh]], crease: float = CREASE) -> list[Appearance]:
    """Return pieces of our own, which have few triangles as they are, as the appearance of a part."""
    return [Appearance(Piece(part, i, color, mesh), corner_normals(mesh, crease)) for i, (color, mesh) in enumerate(pieces)]


def hull_shape(name: str) -> Shape:
    """Return the collision shape that is the hull `name`."""
    return Shape("mesh", name=f"meshes/collision/{name}")


def turned(inertia: FloatArray, rpy: Sequence[float]) -> FloatArray:
    """Return an inertia (3, 3) that is given in turned axes in those of the link."""
    matrix = rotation(rpy)
    result: FloatArray = matrix @ inertia @ matrix.T
    return result


def symmetric(xx: float, yy: float, zz: float, xy: float = 0.0, xz: float = 0.0, yz: float = 0.0) -> FloatArray:
    """Return an inertia (3, 3) from its six numbers [kg m^2]."""
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def frame(name: str) -> ArmLink:
    """Return a link that is a frame alone: it has neither mass nor shapes."""
    return ArmLink(name, 0.0, ZERO, np.zeros((3, 3)))


def read_inertial(link: ET.Element) -> tuple[float, Vec3, FloatArray]:
    """Return mass [kg], centre [m] and inertia about it in the axes of the link (3, 3) of a `<link>` of a URDF."""
    inertial = link.find("inertial")
    assert inertial is not None
    origin, mass, tensor = inertial.find("origin"), inertial.find("mass"), inertial.find("inertia")
    assert mass is not None and tensor is not None
    xyz = read_vector(origin, "xyz")
    own = {key: float(value) for key, value in tensor.attrib.items()}
    matrix = symmetric(*(own[key] for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")))
    return float(mass.attrib["value"]), xyz, turned(matrix, read_vector(origin, "rpy"))


def read_vector(element: ET.Element | None, key: str) -> Vec3:
    """Return three numbers of an element of a URDF; zeros where they are not given."""
    text = "0 0 0" if element is None else element.attrib.get(key, "0 0 0")
    x, y, z = (float(word) for word in text.split())
    return x, y, z


def read_joint(root: ET.Element, name: str, prefix: str = "", replace: Mapping[str, str] | None = None) -> ArmJoint:
    """Return a joint of a URDF.

    Args:
        root: The URDF.
        name: Name of the joint there.
        prefix: Put before the names of joint and links.
        replace: New names of links, without prefix.
    """
    joint = root.find(f"joint[@name='{name}']")
    assert joint is not None
    parent, child, limit, axis = joint.find("parent"), joint.find("child"), joint.find("limit"), joint.find("axis")
    assert parent is not None and child is not None
    names = [prefix + (replace or {}).get(end.attrib["link"], end.attrib["link"]) for end in (parent, child)]
    limits = {} if limit is None else {key: float(value) for key, value in limit.attrib.items() if "acceleration" not in key}
    kind = joint.attrib["type"]
    assert kind in ("revolute", "continuous", "prismatic", "fixed")
    return ArmJoint(
        prefix + name,
        kind,
        names[0],
        names[1],
        read_vector(joint.find("origin"), "xyz"),
        _exact(read_vector(joint.find("origin"), "rpy")),
        (0.0, 0.0, 1.0) if axis is None else read_vector(axis, "xyz"),
        **limits,
        damping=ARM_DAMPING,
    )


def _exact(rpy: Vec3) -> Vec3:
    """Return angles, those that are nearly multiples of a right angle made exact ones."""
    right = math.pi / 2.0
    x, y, z = (round(a / right) * right if abs(a / right - round(a / right)) < 1e-5 else a for a in rpy)
    return x, y, z


def _color_name(color: Rgb, colors: Mapping[str, Rgb]) -> str:
    """Return the name of the nearest of our colours."""
    return min(colors, key=lambda name: sum((a - b) ** 2 for a, b in zip(colors[name], color, strict=True)))


# Writing the URDF -------------------------------------------------------------------------------------------------


def contact_element(*, finger: bool) -> ET.Element:
    """Return the friction of a link; fingers hold best."""
    contact = ET.Element("contact")
    ET.SubElement(contact, "lateral_friction", value="1" if finger else "0.5")
    if finger:
        ET.SubElement(contact, "spinning_friction", value="0.005")
    return contact


def visual_element(mesh: str, color: Rgb) -> ET.Element:
    """Return a coloured visual without its origin."""
    element = ET.Element("visual")
    ET.SubElement(ET.SubElement(element, "geometry"), "mesh", filename=f"meshes/visual/{mesh}.obj")
    material = ET.SubElement(element, "material", name=mesh.rsplit("_", 1)[1])
    ET.SubElement(material, "color", rgba=numbers((*color, 1.0)))
    return element


def _arm_urdf(arm: Arm, visuals: Mapping[str, list[tuple[str, Rgb]]]) -> str:
    """Return the URDF of an arm."""
    root = ET.Element("robot", name=arm.name)
    into = {joint.child: joint for joint in arm.joints}
    for link in arm.links:
        root.append(_link_element(link, visuals))
        if link.name in into:
            root.append(_joint_element(into[link.name]))
    ET.indent(root)
    head = f'<?xml version="1.0"?>\n<!-- Made by scripts/build_assets.py: {arm.source} -->\n'
    return head + ET.tostring(root, encoding="unicode") + "\n"


def _link_element(link: ArmLink, visuals: Mapping[str, list[tuple[str, Rgb]]]) -> ET.Element:
    element = ET.Element("link", name=link.name)
    element.append(contact_element(finger=link.finger))
    for mesh, color in visuals[link.part] if link.part is not None else ():
        visual = visual_element(mesh, color)
        if any(link.visual_rpy):
            visual.insert(0, _origin(ZERO, link.visual_rpy))
        element.append(visual)
    for shape in link.collisions:
        collision = ET.SubElement(element, "collision")
        if any(shape.xyz) or any(shape.rpy):
            collision.append(_origin(shape.xyz, shape.rpy))
        geometry = ET.SubElement(collision, "geometry")
        if shape.kind == "box":
            ET.SubElement(geometry, "box", size=numbers(shape.size))
        else:
            ET.SubElement(geometry, "mesh", filename=f"{shape.name}.obj")
    inertial = ET.SubElement(element, "inertial")
    inertial.append(_origin(link.center, ZERO))
    ET.SubElement(inertial, "mass", value=significant(link.mass))
    names = (("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2))
    clean = np.where(np.abs(link.inertia) < 1e-9 * np.max(np.abs(link.inertia)), 0.0, link.inertia)
    ET.SubElement(inertial, "inertia", {name: significant(clean[i, j]) for name, i, j in names})
    return element


def _joint_element(joint: ArmJoint) -> ET.Element:
    element = ET.Element("joint", name=joint.name, type=joint.kind)
    element.append(_origin(joint.xyz, joint.rpy))
    ET.SubElement(element, "parent", link=joint.parent)
    ET.SubElement(element, "child", link=joint.child)
    if joint.kind == "fixed":
        return element
    ET.SubElement(element, "axis", xyz=numbers(joint.axis))
    limits = {"effort": number(joint.effort), "velocity": number(joint.velocity, 8)}
    if joint.kind != "continuous":
        limits |= {"lower": number(joint.lower, 8), "upper": number(joint.upper, 8)}
    ET.SubElement(element, "limit", limits)
    ET.SubElement(element, "dynamics", damping=number(joint.damping), friction="0")
    if joint.mimic is not None:
        ET.SubElement(element, "mimic", joint=joint.mimic[0], multiplier=number(joint.mimic[1]), offset="0")
    return element


def _origin(xyz: Sequence[float], rpy: Sequence[float]) -> ET.Element:
    return ET.Element("origin", rpy=" ".join(_angle(angle) for angle in rpy), xyz=numbers(xyz, 7))


def _angle(angle: float) -> str:
    """Format an angle so that right angles are exact."""
    return number(angle, 15)
