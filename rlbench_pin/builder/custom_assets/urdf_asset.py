"""Assets from a URDF file: rewritten links, joints, shapes and colours; collision meshes decomposed into convex parts."""

from __future__ import annotations

import math
from collections.abc import Callable
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np
import trimesh

from rlbench_pin.builder.custom_assets.folder import MeshSource
from rlbench_pin.builder.custom_assets.mesh_asset import (
    MAX_EXTENT,
    MOMENTS,
    CustomAsset,
    Inertia,
    check_extent,
    convex_parts,
    format_numbers,
    inertia_of,
    obj_text,
)
from rlbench_pin.builder.custom_assets.uploads import UploadRefused, read_mesh, upload_stem
from rlbench_pin.builder.custom_assets.urdf_file import Numbers, checked_model, joint_end
from rlbench_pin.values import as_number

OnNote = Callable[[str], None]
"""Called with each step of the work."""
MAX_MASS = 1000.0
"""Mass of a link at most [kg]."""
_MAX_SHAPES, _MAX_TRIANGLES = 500, 400_000
_TINY = Inertia(1e-3, np.zeros(3), 1e-7 * np.eye(3))
"""Inertia of a link without mass and shapes."""
_ROUND = 24


def urdf_asset(name: str, data: bytes, source: MeshSource, scale: float, mass: float | None, note: OnNote) -> CustomAsset:
    """Return an asset with the links, joints and meshes of a URDF file.

    Args:
        name: Name of the file.
        data: Content of the file.
        source: Its meshes.
        scale: Factor on all lengths.
        mass: Mass of all links together [kg]; None uses those of the file.
        note: Called with each step of the work.

    Raises:
        UploadRefused: It is not a URDF file, or has invalid values.
        InvalidValue: Scale or mass is not above 0.
    """
    scale = as_number(scale, "scale", above=0.0, most=1e4)
    mass = None if mass is None else as_number(mass, "mass [kg]", above=0.0, most=MAX_MASS)
    root, link_names, joint_names = checked_model(name, data)
    links, joints = root.findall("link"), root.findall("joint")
    stem = upload_stem(name)
    builder = _Builder(name, source, scale, note, root)
    new = Element("robot", name=stem)
    made = [builder.link(new, link, link_names[link.get("name", "").strip()]) for link in links]
    whole = sum(inertia.mass for _, inertia in made)
    for element, inertia in made:
        _add_inertia(element, inertia, 1.0 if mass is None else mass / whole)
    for joint in joints:
        builder.joint(new, joint, joint_names, link_names)
    ElementTree.indent(new)
    text = f'<?xml version="1.0"?>\n{ElementTree.tostring(new, encoding="unicode")}\n'
    return CustomAsset(f"{stem}.urdf", {**builder.files, f"{stem}.urdf": text.encode()})


def _add_inertia(link: Element, inertia: Inertia, factor: float) -> None:
    """Insert the inertia of a link."""
    element = Element("inertial")
    SubElement(element, "origin", xyz=format_numbers(inertia.center), rpy="0 0 0")
    SubElement(element, "mass", value=f"{factor * inertia.mass:.6g}")
    SubElement(element, "inertia", {key: f"{factor * inertia.moments[i, j]:.6g}" for key, i, j in MOMENTS})
    link.insert(1, element)


class _Builder:
    """Rewrites links and joints; `files` has the meshes written so far, by name."""

    def __init__(self, name: str, source: MeshSource, scale: float, note: OnNote, root: Element) -> None:
        self._name, self._source, self._scale, self._note = name, source, scale, note
        self._numbers = Numbers(name)
        self._colors = {m.get("name", ""): self._rgba(m) for m in root.findall("material") if m.find("color") is not None}
        self._read: dict[tuple[str, tuple[float, ...]], trimesh.Trimesh] = {}
        self._parts: dict[tuple[str, tuple[float, ...]], list[trimesh.Trimesh]] = {}
        self._written: dict[int, str] = {}
        self._shapes, self._triangles = 0, 0
        self.files: dict[str, bytes] = {}

    # Links -----------------------------------------------------------------------------------------------------------

    def link(self, robot: Element, link: Element, name: str) -> tuple[Element, Inertia]:
        """Add a link; return it and its inertia, which is written later."""
        new = SubElement(robot, "link", name=name)
        friction = self._numbers.one(link.find("contact/lateral_friction"), "value", "0.8", least=0.0)
        SubElement(SubElement(new, "contact"), "lateral_friction", value=f"{friction:g}")
        seen = [solid for visual in link.findall("visual") for solid in self._visual(new, visual)]
        touched = [solid for collision in link.findall("collision") for solid in self._collision(new, collision)]
        return new, self._inertia(link, touched or [solid.convex_hull for solid in seen if _is_thick(solid)])

    def _visual(self, link: Element, visual: Element) -> list[trimesh.Trimesh]:
        shape = self._shape_of(visual)
        if shape is None:
            return []
        if shape.tag != "mesh":
            geometry, solid = self._primitive(shape)
            self._put(link, visual, geometry, self._color_of(visual))
            return [self._placed(visual, solid)]
        mesh, stem = self._mesh(shape)
        self._put(link, visual, self._mesh_element(mesh, stem), self._color_of(visual))
        return [self._placed(visual, mesh)]

    def _collision(self, link: Element, collision: Element) -> list[trimesh.Trimesh]:
        shape = self._shape_of(collision)
        if shape is None:
            return []
        if shape.tag != "mesh":
            geometry, solid = self._primitive(shape)
            self._put(link, collision, geometry, None)
            return [self._placed(collision, solid)]
        mesh, stem = self._mesh(shape)
        key = (stem, self._mesh_scale(shape))
        if key not in self._parts:
            self._note(f"Decomposing '{stem}' into convex parts")
            self._parts[key] = convex_parts(stem, mesh)
        for part in self._parts[key]:
            self._put(link, collision, self._mesh_element(part, f"{stem}_part"), None)
        return [self._placed(collision, part) for part in self._parts[key]]

    def _put(self, link: Element, element: Element, geometry: Element, color: tuple[float, ...] | None) -> None:
        new = SubElement(link, element.tag)
        self._origin(new, element)
        SubElement(new, "geometry").append(geometry)
        if color is not None:
            number = sum(1 for _ in link.iter("material"))
            material = SubElement(new, "material", name=f"{link.get('name')}_{number}")
            SubElement(material, "color", rgba=format_numbers(color))

    def _shape_of(self, element: Element) -> Element | None:
        self._shapes += 1
        if self._shapes > _MAX_SHAPES:
            raise UploadRefused(self._name, f"it has more than {_MAX_SHAPES} shapes", "Reduce them first.")
        geometry = element.find("geometry")
        return geometry[0] if geometry is not None and len(geometry) else None

    def _primitive(self, shape: Element) -> tuple[Element, trimesh.Trimesh]:
        """Return a scaled primitive, as an element and as a mesh."""
        positive, most = self._numbers.positive, MAX_EXTENT / self._scale
        if shape.tag == "box":
            size = self._scale * np.array(positive(shape, "size", 3, "", most))
            return Element("box", size=format_numbers(size)), trimesh.creation.box(size)
        if shape.tag not in ("sphere", "cylinder", "capsule"):
            problem = f"a shape is <{shape.tag[:40]}>"
            raise UploadRefused(self._name, problem, "Shapes are box, sphere, cylinder, capsule and mesh.")
        radius = self._scale * positive(shape, "radius", 1, "", most)[0]
        if shape.tag == "sphere":
            return Element("sphere", radius=format_numbers([radius])), trimesh.creation.uv_sphere(radius, count=[_ROUND, _ROUND])
        length = self._scale * positive(shape, "length", 1, "", most)[0]
        make = trimesh.creation.cylinder if shape.tag == "cylinder" else trimesh.creation.capsule
        sides = {"sections": _ROUND} if shape.tag == "cylinder" else {"count": [_ROUND, _ROUND]}
        return Element(shape.tag, radius=format_numbers([radius]), length=format_numbers([length])), make(
            radius=radius, height=length, **sides
        )

    # Meshes ----------------------------------------------------------------------------------------------------------

    def _mesh_scale(self, shape: Element) -> tuple[float, ...]:
        return self._numbers.positive(shape, "scale", 3, "1 1 1", 1e4)

    def _mesh(self, shape: Element) -> tuple[trimesh.Trimesh, str]:
        """Return a scaled mesh and the stem of its file."""
        file = self._source.find(self._name, shape.get("filename", ""))
        key = (file, self._mesh_scale(shape))
        stem = upload_stem(file)
        if key not in self._read:
            self._note(f"Reading '{file}'")
            mesh = read_mesh(file, self._source.read(file)).mesh
            mesh.apply_transform(np.diag([*(self._scale * np.array(key[1])), 1.0]))
            check_extent(file, mesh.bounds[1] - mesh.bounds[0])
            self._triangles += len(mesh.faces)
            if self._triangles > _MAX_TRIANGLES:
                raise UploadRefused(self._name, f"its meshes have more than {_MAX_TRIANGLES} triangles", "Reduce them first.")
            self._read[key] = mesh
        return self._read[key], stem

    def _mesh_element(self, mesh: trimesh.Trimesh, stem: str) -> Element:
        """Write a mesh once, and return the element that names it."""
        if id(mesh) not in self._written:
            numbers = (f"{stem}{number or ''}.obj" for number in range(10**6))
            self._written[id(mesh)] = next(name for name in numbers if name not in self.files)
            self.files[self._written[id(mesh)]] = obj_text(mesh).encode()
        return Element("mesh", filename=self._written[id(mesh)])

    # Origins ---------------------------------------------------------------------------------------------------------

    def _place(self, element: Element) -> tuple[np.ndarray, np.ndarray]:
        """Return scaled position (3,) and roll, pitch, yaw (3,) of an origin."""
        origin = element.find("origin")
        xyz, rpy = (np.array(self._numbers.several(origin, key, 3, "0 0 0")) for key in ("xyz", "rpy"))
        return self._scale * xyz, rpy

    def _origin(self, new: Element, element: Element) -> None:
        xyz, rpy = self._place(element)
        SubElement(new, "origin", xyz=format_numbers(xyz), rpy=format_numbers(rpy))

    def _placed(self, element: Element, mesh: trimesh.Trimesh) -> trimesh.Trimesh:
        xyz, rpy = self._place(element)
        matrix = trimesh.transformations.euler_matrix(*rpy, "sxyz")
        matrix[:3, 3] = xyz
        return mesh.copy().apply_transform(matrix)

    # Colour and mass -------------------------------------------------------------------------------------------------

    def _color_of(self, visual: Element) -> tuple[float, ...]:
        material = visual.find("material")
        if material is None:
            return (0.8, 0.8, 0.8, 1.0)
        if material.find("color") is not None:
            return self._rgba(material)
        return self._colors.get(material.get("name", ""), (0.8, 0.8, 0.8, 1.0))

    def _rgba(self, material: Element) -> tuple[float, ...]:
        numbers = self._numbers.several(material.find("color"), "rgba", 4, "1 1 1 1")
        return tuple(min(max(number, 0.0), 1.0) for number in numbers)

    def _inertia(self, link: Element, solids: list[trimesh.Trimesh]) -> Inertia:
        """Return the inertia given in the file; without one, that of its solids, or a tiny one."""
        inertial = link.find("inertial")
        given = None if inertial is None else inertial.find("mass")
        mass = 0.0 if given is None else self._numbers.one(given, "value", "0", least=0.0)
        if mass > MAX_MASS:
            raise UploadRefused(self._name, f"a link has {mass:g} kg", f"The limit is {MAX_MASS:g} kg.")
        if inertial is not None and mass > 0.0:
            moments = self._moments(inertial.find("inertia"))
            xyz, rpy = self._place(inertial)
            if np.linalg.eigvalsh(moments).min() > 0.0:
                turn = trimesh.transformations.euler_matrix(*rpy, "sxyz")[:3, :3]
                return Inertia(mass, xyz, turn @ moments @ turn.T * self._scale**2)
            if not solids:
                return Inertia(mass, xyz, 1e-4 * mass * np.eye(3))
        return inertia_of(solids, mass or None) if solids else _TINY

    def _moments(self, element: Element | None) -> np.ndarray:
        moments = np.zeros((3, 3))
        for key, i, j in MOMENTS:
            moments[i, j] = moments[j, i] = self._numbers.one(element, key, "0")
        return moments

    # Joints ----------------------------------------------------------------------------------------------------------

    def joint(self, robot: Element, joint: Element, joints: dict[str, str], links: dict[str, str]) -> None:
        """Add a joint; `joints` and `links` give the new names."""
        name = joints[joint.get("name", "").strip()]
        kind = joint.get("type", "")
        new = SubElement(robot, "joint", name=name, type=kind)
        self._origin(new, joint)
        for end in ("parent", "child"):
            SubElement(new, end, link=links[joint_end(joint, end)])
        if kind == "fixed":
            return
        axis = np.array(self._numbers.several(joint.find("axis"), "xyz", 3, "1 0 0"))
        if np.linalg.norm(axis) < 1e-9:
            raise UploadRefused(self._name, f"joint '{name}' has the axis 0 0 0", "Give it a direction.")
        SubElement(new, "axis", xyz=format_numbers(axis / np.linalg.norm(axis)))
        self._add_limits(new, joint, kind)
        dynamics = joint.find("dynamics")
        if dynamics is not None:
            values = {key: f"{self._numbers.one(dynamics, key, '0', least=0.0):g}" for key in ("damping", "friction")}
            SubElement(new, "dynamics", values)
        mimic = joint.find("mimic")
        if mimic is not None:
            self._add_mimic(new, mimic, joints)

    def _add_mimic(self, new: Element, mimic: Element, joints: dict[str, str]) -> None:
        leader = mimic.get("joint", "").strip()
        if leader not in joints:
            problem = f"joint '{new.get('name')}' mimics the joint '{leader[:60]}', which does not exist"
            raise UploadRefused(self._name, problem, "Correct its name.")
        ratio, offset = self._numbers.one(mimic, "multiplier", "1"), self._numbers.one(mimic, "offset", "0")
        SubElement(new, "mimic", joint=joints[leader], multiplier=f"{ratio:.9g}", offset=f"{offset:.9g}")

    def _add_limits(self, new: Element, joint: Element, kind: str) -> None:
        limit, one = joint.find("limit"), self._numbers.one
        effort, velocity = one(limit, "effort", "100", least=0.0), one(limit, "velocity", "10", least=0.0)
        rest = {"effort": f"{effort or 100.0:g}", "velocity": f"{velocity or 10.0:g}"}
        if kind == "continuous":
            SubElement(new, "limit", rest)
            return
        factor = self._scale if kind == "prismatic" else 1.0
        lower, upper = factor * one(limit, "lower", "0"), factor * one(limit, "upper", "0")
        if limit is None or not lower <= upper or max(abs(lower), abs(upper)) > 8.0 * math.pi:
            problem = f"joint '{new.get('name')}' has no limits" if limit is None else f"its limits are {lower:g} to {upper:g}"
            raise UploadRefused(self._name, problem, 'A joint that moves needs <limit lower="..." upper="..."/>.')
        SubElement(new, "limit", {"lower": f"{lower:.9g}", "upper": f"{upper:.9g}", **rest})


def _is_thick(solid: trimesh.Trimesh) -> bool:
    return bool(min(solid.extents) > 1e-4)
