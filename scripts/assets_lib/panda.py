"""The Franka Panda: light visual meshes and small hulls derived from the files of example-robot-data (Apache-2.0)."""

from __future__ import annotations

import importlib.util
import math
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

from assets_lib.dae import Rgb, read_dae
from assets_lib.decimate import decimate, seen_from_outside, small_hull
from assets_lib.files import numbers, obj_text, write_text
from assets_lib.mesh import FloatArray, Mesh, merge

FOLDER = "robots/panda"
HULL_VERTICES = 64
COLORS: dict[str, Rgb] = {
    "white": (0.93, 0.94, 0.95),
    "dark": (0.16, 0.16, 0.18),
    "gray": (0.66, 0.67, 0.69),
    "blue": (0.04, 0.54, 0.78),
    "red": (0.8, 0.1, 0.1),
    "green": (0.1, 0.7, 0.2),
}
BUDGET: dict[str, int] = {
    "link0": 460, "link1": 290, "link2": 290, "link3": 350, "link4": 350,
    "link5": 540, "link6": 480, "link7": 260, "hand": 240, "finger": 70,
}  # fmt: skip
"""Visual triangles of each part."""


REPAINT = {("hand", "white"): "dark", ("hand", "gray"): "dark", ("finger", "white"): "gray"}
"""The hand is dark with light fingers, so that its opening is seen in small pictures."""


def source_folder() -> Path:
    """Return the folder `panda_description` of example-robot-data, next to the installed cmeel packages."""
    spec = importlib.util.find_spec("cmeel") or importlib.util.find_spec("numpy")
    assert spec is not None and spec.origin is not None
    return Path(spec.origin).parents[1] / "cmeel.prefix/share/example-robot-data/robots/panda_description"


def build_panda(assets: Path) -> None:
    """Write the robot's URDF, SRDF, meshes and licence below `assets`."""
    source, target = source_folder(), assets / FOLDER
    visuals = {part: _build_visuals(source, target, part) for part in BUDGET}
    for part in BUDGET:
        if part != "finger":
            points = _read_stl(source / f"meshes/collision/{part}.stl")
            hull = small_hull(points, HULL_VERTICES)
            write_text(target / f"meshes/collision/{part}.obj", obj_text(hull, crease=None))
    write_text(target / "panda.urdf", _urdf(source, visuals))
    write_text(target / "panda.srdf", (source / "srdf/panda.srdf").read_text())
    write_text(target / "LICENSE", (source / "LICENSE").read_text())


def _build_visuals(source: Path, target: Path, part: str) -> list[tuple[str, Rgb]]:
    """Write `<part>_<color>.obj` files and return their names and colours."""
    pieces = read_dae(source / f"meshes/visual/{part}.dae")
    seen = seen_from_outside([mesh for _, mesh in pieces])
    groups: dict[str, list[Mesh]] = {}
    for (color, _), mesh in zip(pieces, seen, strict=True):
        if len(mesh.faces):
            name = _color_name(color)
            groups.setdefault(REPAINT.get((part, name), name), []).append(mesh)
    merged = {name: merge(meshes) for name, meshes in sorted(groups.items())}
    areas = {name: _area(mesh) for name, mesh in merged.items()}
    result = []
    for name, mesh in merged.items():
        share = (areas[name] / sum(areas.values())) ** 0.75
        total = sum((a / sum(areas.values())) ** 0.75 for a in areas.values())
        light = decimate(mesh, max(12, int(BUDGET[part] * share / total)))
        if name == "dark" and len(merged) > 1:
            light = _grown(light, 0.0012)
        write_text(target / f"meshes/visual/{part}_{name}.obj", obj_text(light, crease=0.8))
        result.append((f"{part}_{name}", COLORS[name]))
    return result


def _grown(mesh: Mesh, distance: float) -> Mesh:
    """Shift every vertex outwards, so that thin dark covers stay above the white shells that they lie on."""
    normals = np.zeros_like(mesh.vertices)
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    for i in range(3):
        np.add.at(normals, mesh.faces[:, i], np.cross(b - a, c - a))
    lengths = np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    return Mesh(mesh.vertices + distance * normals / lengths, mesh.faces)


def _area(mesh: Mesh) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)


def _color_name(color: Rgb) -> str:
    """Return the name of the nearest of our colours."""
    return min(COLORS, key=lambda name: sum((a - b) ** 2 for a, b in zip(COLORS[name], color, strict=True)))


def _read_stl(path: Path) -> FloatArray:
    """Return all corners of a binary STL file, shape (n, 3) [m]."""
    raw = path.read_bytes()
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("pad", "<u2")])
    return np.unique(np.frombuffer(raw[84:], dtype=record)["corners"].reshape(-1, 3).astype(float), axis=0)


def _urdf(source: Path, visuals: dict[str, list[tuple[str, Rgb]]]) -> str:
    """Return the robot's URDF with our meshes, without the mimic tag and the names that only ROS uses."""
    root = ET.parse(source / "urdf/panda.urdf").getroot()
    for link in root.iterfind("link"):
        for visual in link.findall("visual"):
            _replace_visual(link, visual, visuals)
        for mesh in link.iterfind("collision/geometry/mesh"):
            mesh.set("filename", f"meshes/collision/{Path(mesh.attrib['filename']).stem}.obj")
    for joint in root.iterfind("joint"):
        for tag in ("mimic", "safety_controller"):
            for element in joint.findall(tag):
                joint.remove(element)
        dynamics = joint.find("dynamics")
        if dynamics is not None:
            dynamics.attrib = {"damping": dynamics.attrib["damping"], "friction": "0"}
    _turn_tip(root)
    _add_contact(root)
    ET.indent(root)
    text = ET.tostring(root, encoding="unicode")
    head = '<?xml version="1.0"?>\n'
    head += "<!-- Derived by scripts/build_assets.py from franka_description (Apache-2.0, see LICENSE). -->\n"
    return head + re.sub(r' xmlns:\w+="[^"]*"', "", text) + "\n"


def _turn_tip(root: ET.Element) -> None:
    """Turn the tip frame half round about the hand's z: a hand that points down ahead of the base is then (0, 1, 0, 0)."""
    origin = root.find("joint[@name='panda_hand_tcp_joint']/origin")
    assert origin is not None
    origin.set("rpy", f"0 0 {math.pi}")


def _replace_visual(link: ET.Element, visual: ET.Element, visuals: dict[str, list[tuple[str, Rgb]]]) -> None:
    """Put one coloured visual element per mesh in the place of the original."""
    mesh = visual.find("geometry/mesh")
    assert mesh is not None
    place = list(link).index(visual)
    origin = visual.find("origin")
    link.remove(visual)
    for i, (name, color) in enumerate(visuals[Path(mesh.attrib["filename"]).stem]):
        element = ET.Element("visual")
        if origin is not None:
            element.append(origin)
        ET.SubElement(ET.SubElement(element, "geometry"), "mesh", filename=f"meshes/visual/{name}.obj")
        material = ET.SubElement(element, "material", name=name.split("_")[1])
        ET.SubElement(material, "color", rgba=numbers((*color, 1.0)))
        link.insert(place + i, element)


def _add_contact(root: ET.Element) -> None:
    """Give every link its friction; the pads hold best."""
    for link in root.iterfind("link"):
        friction = "1" if "finger" in link.attrib["name"] else "0.5"
        contact = ET.Element("contact")
        ET.SubElement(contact, "lateral_friction", value=friction)
        if "finger" in link.attrib["name"]:
            ET.SubElement(contact, "spinning_friction", value="0.005")
        link.insert(0, contact)
