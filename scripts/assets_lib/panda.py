"""The Franka Panda: light visual meshes and small hulls derived from the files of example-robot-data (Apache-2.0)."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

from assets_lib.arm_appearance import light_appearances
from assets_lib.arms import contact_element, visual_element, write_hull, write_visuals
from assets_lib.dae import Rgb, read_dae
from assets_lib.files import write_text
from assets_lib.source_meshes import example_folder, read_stl

FOLDER = "robots/panda"
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


def build_panda(assets: Path) -> None:
    """Write the robot's URDF, SRDF, meshes and licence below `assets`."""
    source, target = example_folder("panda_description"), assets / FOLDER
    parts = {part: read_dae(source / f"meshes/visual/{part}.dae") for part in PARTS}
    visuals = write_visuals(target, light_appearances(parts, WEIGHTS, TRIANGLES), COLORS, REPAINT)
    for part in PARTS:
        if part != "finger":
            points = np.unique(read_stl(source / f"meshes/collision/{part}.stl").vertices, axis=0)
            write_hull(target, part, points)
    write_text(target / "panda.urdf", _urdf(source, visuals))
    write_text(target / "panda.srdf", (source / "srdf/panda.srdf").read_text())
    write_text(target / "LICENSE", (source / "LICENSE").read_text())


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
        element = visual_element(name, color)
        if origin is not None:
            element.insert(0, origin)
        link.insert(place + i, element)


def _add_contact(root: ET.Element) -> None:
    """Give every link its friction; the pads hold best."""
    for link in root.iterfind("link"):
        link.insert(0, contact_element(finger="finger" in link.attrib["name"]))
