"""Builds the URDF file and the meshes of an arm with a gripper from the URDF files of both.

Visual meshes are decimated, collision meshes of the arm become convex hulls and those of the gripper convex parts. All are
written as OBJ files. A moving joint outside of the chain from the base to the flange is refused; the error names it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np
import trimesh

from rlbench_pin.builder.custom_assets.folder import MeshSource
from rlbench_pin.builder.custom_assets.mesh_asset import CustomAsset, format_numbers, obj_text
from rlbench_pin.builder.custom_assets.uploads import UploadRefused
from rlbench_pin.builder.custom_assets.urdf_asset import OnNote, urdf_asset
from rlbench_pin.builder.custom_assets.urdf_file import checked_model, clean_names, joint_end, parse_xml
from rlbench_pin.robot.description import robot_description
from rlbench_pin.robot.geometry import mesh_surface
from rlbench_pin.robot.mounting import Mount

GRIPPER_OF = "xarm7"
"""Arm of the catalogue whose URDF has the shared parallel gripper."""
MAX_VISUAL_TRIANGLES = 3000
"""Triangles of a visual mesh at most; renderers take 0.2 us for each."""
DEFAULT_VELOCITY, DEFAULT_EFFORT = 1.0, 50.0
"""Limits of a joint where the URDF has none [rad/s], [N m]."""
DAMPING = 0.003
"""Damping of the joints of all arms, as in the Panda's file: motors model the drives [N m s/rad]."""
_SOLID_TRIANGLES = 20000
_SHAPES = ("visual", "collision")


@dataclass(frozen=True)
class Gripper:
    """URDF file of a gripper, and its files."""

    asset: CustomAsset
    base: str
    """Its first link."""


def arm_asset(name: str, urdf: Path, flange: str, note: OnNote) -> tuple[CustomAsset, str, tuple[str, ...]]:
    """Return the arm without a gripper: all links except those below the flange.

    Args:
        name: Name of the arm.
        urdf: Its URDF file.
        flange: Link that carries the gripper; empty for the last link.
        note: Called with each step of the work.

    Returns:
        Files of the arm, the new name of the flange, and a line for each number that the URDF does not give.

    Raises:
        UploadRefused: The file is invalid, has no such link, or has a moving joint outside of the chain to the flange.
    """
    root = _read(urdf)
    tree = _Tree(root)
    flange = flange or tree.end()
    if flange not in tree.links:
        raise UploadRefused(urdf.name, f"it has no link '{flange}'", f"Links: {', '.join(tree.links)}.")
    _remove_below(root, tree, flange)
    _remove_world(root, tree)
    tree = _Tree(root)
    chain = {joint.get("name") for joint in tree.above(flange)}
    beside = [joint.get("name", "") for joint in tree.moving() if joint.get("name") not in chain]
    if beside:
        hint = f"Give the link that carries the gripper with --flange. Links: {', '.join(tree.links)}."
        raise UploadRefused(urdf.name, f"its joint '{beside[0]}' moves, but is not in the chain to '{flange}'", hint)
    missing = [line for joint in tree.moving() for line in _complete(joint)]
    missing += [f"mass of link {link}" for link in _without_mass(root)]
    source = _converted(urdf, root, hulls=True)  # it renames the meshes in the tree
    asset = urdf_asset(f"{name}.urdf", _text(root), source, 1.0, None, note)
    return asset, clean_names(urdf.name, root.findall("link"))[flange], tuple(missing)


def gripper_asset(name: str, urdf: Path, note: OnNote) -> Gripper:
    """Return a gripper with names that begin with the name of the arm.

    Raises:
        UploadRefused: The file cannot be used.
    """
    root = _read(urdf)
    for element in root.iter():
        for key in ("name", "link", "joint"):
            if element.tag in ("link", "joint", "parent", "child", "mimic") and key in element.attrib:
                element.set(key, f"{name}_{element.attrib[key].strip()}")
    for link in root.iterfind("link"):
        if link.find("contact") is None:
            SubElement(SubElement(link, "contact"), "lateral_friction", value="1")
    source = _converted(urdf, root, hulls=False)
    asset = urdf_asset(f"{name}_gripper.urdf", _text(root), source, 1.0, None, note)
    return Gripper(asset, clean_names(urdf.name, root.findall("link"))[_Tree(root).base])


def shared_gripper(name: str) -> Gripper:
    """Return the parallel gripper of the arms of the catalogue that have no gripper of their own."""
    file = robot_description(GRIPPER_OF).urdf
    root, hand = parse_xml(file.name, file.read_bytes()), f"{GRIPPER_OF}_hand"
    tree = _Tree(root)
    kept = {link for link in tree.links if link == hand or hand in tree.path(link)}
    for element in [e for e in root if (e.get("name") if e.tag == "link" else joint_end(e, "child")) not in kept]:
        root.remove(element)
    for joint in [joint for joint in root.iterfind("joint") if joint_end(joint, "child") == hand]:
        root.remove(joint)
    files: dict[str, bytes] = {}
    for mesh in root.iter("mesh"):
        path = Path(mesh.attrib["filename"])
        mesh.set("filename", f"gripper_{path.parent.name}_{path.name}")
        files[mesh.attrib["filename"]] = (file.parent / path).read_bytes()
    text = _text(root).replace(f'"{GRIPPER_OF}_'.encode(), f'"{name}_'.encode())
    return Gripper(CustomAsset(f"{name}_gripper.urdf", {**files, f"{name}_gripper.urdf": text}), f"{name}_hand")


def joined(name: str, arm: CustomAsset, flange: str, gripper: Gripper, mount: Mount) -> CustomAsset:
    """Return arm and gripper as one URDF file, its meshes in the folder `meshes`.

    Args:
        name: Name of the arm.
        arm: The arm.
        flange: Link that carries the gripper.
        gripper: The gripper.
        mount: Pose of the gripper in the flange.

    Raises:
        UploadRefused: Arm and gripper have a link or a joint of the same name.
    """
    root, other = (ElementTree.fromstring(asset.files[asset.urdf]) for asset in (arm, gripper.asset))
    names = {(e.tag, e.get("name")) for e in root}
    for element in other:
        if (element.tag, element.get("name")) in names:
            raise UploadRefused(
                gripper.asset.urdf, f"the arm has a {element.tag} '{element.get('name')}', too", "Choose another NAME."
            )
    joint = fixed_joint(f"{name}_mount", flange, gripper.base, mount)
    root.extend([*other.findall("link"), joint, *other.findall("joint")])
    root.set("name", name)
    meshes = {}
    for asset in (arm, gripper.asset):
        meshes.update({f"meshes/{file}": content for file, content in asset.files.items() if file != asset.urdf})
    for mesh in root.iter("mesh"):
        mesh.set("filename", f"meshes/{mesh.attrib['filename']}")
    return CustomAsset(f"{name}.urdf", {**meshes, f"{name}.urdf": _text(root, indent=True)})


def fixed_joint(name: str, parent: str, child: str, place: Mount) -> Element:
    """Return a fixed joint."""
    joint = Element("joint", name=name, type="fixed")
    SubElement(joint, "origin", xyz=format_numbers(place.xyz), rpy=format_numbers(place.rpy))
    SubElement(joint, "parent", link=parent)
    SubElement(joint, "child", link=child)
    return joint


def changed(asset: CustomAsset, change: Callable[[Element], None]) -> CustomAsset:
    """Return an asset with the URDF file changed by a function."""
    root = ElementTree.fromstring(asset.files[asset.urdf])
    change(root)
    return CustomAsset(asset.urdf, {**asset.files, asset.urdf: _text(root)})


# The tree of an arm -------------------------------------------------------------------------------------------------


class _Tree:
    """Links and joints of a URDF file that is known to be a tree."""

    def __init__(self, root: Element) -> None:
        self._joints = {joint_end(joint, "child"): joint for joint in root.iterfind("joint")}
        self.links = [link.get("name", "").strip() for link in root.iterfind("link")]
        self.base = next(link for link in self.links if link not in self._joints)

    def above(self, link: str) -> list[Element]:
        """Return the joints from a link up to the base."""
        joints = []
        while link in self._joints:
            joints.append(self._joints[link])
            link = joint_end(joints[-1], "parent")
        return joints

    def path(self, link: str) -> set[str]:
        """Return the links above a link."""
        return {joint_end(joint, "parent") for joint in self.above(link)}

    def moving(self) -> list[Element]:
        """Return the joints that are not fixed."""
        return [joint for joint in self._joints.values() if joint.get("type") != "fixed"]

    def end(self) -> str:
        """Return the link with most moving joints above it; of several, the one farthest down."""

        def depth(link: str) -> tuple[int, int]:
            joints = self.above(link)
            return sum(joint.get("type") != "fixed" and joint.find("mimic") is None for joint in joints), len(joints)

        return max(self.links, key=depth)


def _read(urdf: Path) -> Element:
    try:
        data = urdf.read_bytes()
    except OSError as error:
        raise UploadRefused(
            urdf.name, f"it cannot be read: {error.strerror}", "Name a URDF file; convert a xacro file with `xacro`."
        ) from error
    root, _, _ = checked_model(urdf.name, data)
    for element in [e for e in root if e.tag not in ("link", "joint", "material")]:
        root.remove(element)  # gazebo, transmission: of other programs
    return root


def _text(root: Element, indent: bool = False) -> bytes:
    if indent:
        ElementTree.indent(root)
    return b'<?xml version="1.0"?>\n' + ElementTree.tostring(root) + b"\n"


def _remove_below(root: Element, tree: _Tree, flange: str) -> None:
    below = {link for link in tree.links if flange in tree.path(link)}
    for element in [e for e in root.findall("link") if e.get("name", "").strip() in below]:
        root.remove(element)
    for element in [e for e in root.findall("joint") if joint_end(e, "child") in below]:
        root.remove(element)


def _remove_world(root: Element, tree: _Tree) -> None:
    """Remove a first link that is only a frame at the pose of the base, because PyBullet fixes the first link."""
    base = next(link for link in root.iterfind("link") if link.get("name", "").strip() == tree.base)
    joints = [joint for joint in root.iterfind("joint") if joint_end(joint, "parent") == tree.base]
    if len(joints) != 1 or joints[0].get("type") != "fixed" or any(base.find(role) is not None for role in _SHAPES):
        return
    origin = joints[0].find("origin")
    if origin is None or not any(float(n) for key in ("xyz", "rpy") for n in origin.get(key, "0 0 0").split()):
        root.remove(base)
        root.remove(joints[0])


def _complete(joint: Element) -> list[str]:
    """Fill in the limits and the damping of a joint of the arm; return what its URDF does not give."""
    limit, lines = joint.find("limit"), []
    limit = SubElement(joint, "limit") if limit is None and joint.get("type") == "continuous" else limit
    for key, default, unit in (("velocity", DEFAULT_VELOCITY, "rad/s"), ("effort", DEFAULT_EFFORT, "N m")):
        if limit is not None and not float(limit.get(key, "0") or "0") > 0.0:
            limit.set(key, f"{default:g}")
            lines.append(f"{key} of joint {joint.get('name')}: {default:g} {unit} assumed, in <limit> of the URDF")
    for dynamics in joint.findall("dynamics"):
        joint.remove(dynamics)
    SubElement(joint, "dynamics", damping=f"{DAMPING:g}", friction="0")
    return lines


def _without_mass(root: Element) -> list[str]:
    """Return links with shapes and without a mass."""
    return [
        link.get("name", "")
        for link in root.iterfind("link")
        if link.find("inertial/mass") is None and any(link.find(role) is not None for role in _SHAPES)
    ]


# Meshes -------------------------------------------------------------------------------------------------------------


def _converted(urdf: Path, root: Element, hulls: bool) -> MeshSource:
    """Give every mesh of a URDF file its own name as an OBJ file, and return the source that converts them."""
    files: dict[str, tuple[Path, str]] = {}
    names: dict[tuple[Path, str], str] = {}
    for role in _SHAPES:
        for mesh in root.iterfind(f"link/{role}/geometry/mesh"):
            key = (mesh_file(urdf, mesh.get("filename", "")), role)
            stem = f"{key[0].stem.lower()}_{role}"
            choices = (f"{stem}{number or ''}.obj" for number in range(len(names) + 1))
            names.setdefault(key, next(choice for choice in choices if choice not in files or files[choice] == key))
            files[names[key]] = key
            mesh.set("filename", names[key])
    for link in root.iterfind("link"):
        if link.find("contact") is None:
            SubElement(SubElement(link, "contact"), "lateral_friction", value="0.5")

    def read(name: str) -> bytes:
        file, role = files[name]
        surface = trimesh.Trimesh(*mesh_surface(file), process=False)
        if role == "visual":
            return obj_text(thinned(surface, MAX_VISUAL_TRIANGLES)).encode()
        surface = thinned(surface, _SOLID_TRIANGLES)
        return obj_text(surface.convex_hull if hulls else surface).encode()

    return MeshSource("the folder of the URDF file", files, read)


def mesh_file(urdf: Path, filename: str) -> Path:
    """Return the file that a mesh element names: a path from the URDF file, or from one of the five folders above it.

    Raises:
        UploadRefused: The file does not exist.
    """
    parts = [part for part in filename.replace("\\", "/").partition("://")[2].split("/") if part]
    plain = urdf.parent / filename
    if not parts and plain.is_file():
        return plain
    parts = parts or [part for part in filename.replace("\\", "/").split("/") if part not in ("", ".", "..")]
    for folder in list(urdf.absolute().parents)[:5]:
        for first in range(len(parts)):
            file = folder.joinpath(*parts[first:])
            if file.is_file():
                return file
    raise UploadRefused(urdf.name, f"the mesh '{filename[:120]}' is not found", "Copy the meshes to the folder of the URDF file.")


def thinned(mesh: trimesh.Trimesh, most: int) -> trimesh.Trimesh:
    """Return a mesh with at most `most` triangles: vertices in one cell of a grid are merged, with ever coarser grids."""
    if len(mesh.faces) <= most:
        return mesh
    corners, faces, cells = np.asarray(mesh.vertices), np.asarray(mesh.faces), 256.0
    while True:
        steps = np.floor((corners - corners.min(axis=0)) * (cells / np.ptp(corners, axis=0).max())).astype(np.int64)
        _, cell = np.unique(steps @ (1, 2**20, 2**40), return_inverse=True)
        moved = cell[faces]
        kept = moved[(moved[:, 0] != moved[:, 1]) & (moved[:, 1] != moved[:, 2]) & (moved[:, 0] != moved[:, 2])]
        if len(kept) <= most:
            break
        cells /= 1.2
    count = np.bincount(cell)
    middles = np.stack([np.bincount(cell, weights=column) / count for column in corners.T], axis=1)
    return trimesh.Trimesh(middles, kept, process=False)
