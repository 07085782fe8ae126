"""The Franka Panda: light visual meshes and small hulls derived from the files of example-robot-data (Apache-2.0)."""

from __future__ import annotations

import importlib.util
import math
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

from assets_lib.arm_appearance import Appearance, light_appearances
from assets_lib.dae import Rgb, read_dae
from assets_lib.decimate import small_hull
from assets_lib.files import numbers, obj_text, write_text
from assets_lib.mesh import FloatArray, merge

FOLDER = "robots/panda"
HULL_VERTICES = 64
COLORS: dict[str, Rgb] = {
    "white": (0.93, 0.94, 0.95),
    "dark": (0.16, 0.16, 0.18),
    "gray": (0.66, 0.67, 0.69),
}
PARTS = (*(f"link{i}" for i in range(8)), "hand", "finger")
TRIANGLES = 4600
"""Of all visual meshes; a finger counts once."""
WEIGHTS = {"hand": 4.0, "finger": 10.0, "link7": 1.5, "link0": 0.3}
"""How much more than others a part counts: the wrist camera looks at hand and fingers, nobody at the sockets of the base."""
REPAINT = {("finger", "white"): "gray"}
"""The fingers are darker than the hand, so that its opening is seen in small pictures; their pads are black."""


def source_folder() -> Path:
    """Return the folder `panda_description` of example-robot-data, next to the installed cmeel packages."""
    spec = importlib.util.find_spec("cmeel") or importlib.util.find_spec("numpy")
    assert spec is not None and spec.origin is not None
    return Path(spec.origin).parents[1] / "cmeel.prefix/share/example-robot-data/robots/panda_description"


def build_panda(assets: Path) -> None:
    """Write the robot's URDF, SRDF, meshes and licence below `assets`."""
    source, target = source_folder(), assets / FOLDER
    visuals = _build_visuals(source, target)
    for part in PARTS:
        if part != "finger":
            points = _read_stl(source / f"meshes/collision/{part}.stl")
            hull = small_hull(points, HULL_VERTICES)
            write_text(target / f"meshes/collision/{part}.obj", obj_text(hull, crease=None))
    write_text(target / "panda.urdf", _urdf(source, visuals))
    write_text(target / "panda.srdf", (source / "srdf/panda.srdf").read_text())
    write_text(target / "LICENSE", (source / "LICENSE").read_text())


def _build_visuals(source: Path, target: Path) -> dict[str, list[tuple[str, Rgb]]]:
    """Write `<part>_<color>.obj` files and return their names and colours for each part."""
    looks = light_appearances({part: read_dae(source / f"meshes/visual/{part}.dae") for part in PARTS}, WEIGHTS, TRIANGLES)
    groups: dict[tuple[str, str], list[Appearance]] = {}
    for look in looks:
        part, name = look.piece.part, _color_name(look.piece.color)
        groups.setdefault((part, REPAINT.get((part, name), name)), []).append(look)
    result: dict[str, list[tuple[str, Rgb]]] = {part: [] for part in PARTS}
    for (part, name), same in sorted(groups.items()):
        mesh = merge([look.piece.mesh for look in same])
        text = obj_text(mesh, crease=0.8, normals=np.concatenate([look.normals for look in same]))
        write_text(target / f"meshes/visual/{part}_{name}.obj", text)
        result[part].append((f"{part}_{name}", COLORS[name]))
    return result


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
