"""Read the triangles and plain colours of a COLLADA file; other parts of the format are not supported."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

from assets_lib.mesh import Mesh

NS = {"c": "http://www.collada.org/2005/11/COLLADASchema"}
Rgb = tuple[float, float, float]


def read_dae(path: Path) -> list[tuple[Rgb, Mesh]]:
    """Return the meshes of a file in its root frame [m], each with its diffuse colour."""
    root = ET.parse(path).getroot()
    colors = _material_colors(root)
    geometries = {g.attrib["id"]: g for g in root.iterfind(".//c:geometry", NS)}
    result: list[tuple[Rgb, Mesh]] = []
    for node in root.iterfind(".//c:visual_scene//c:node", NS):
        matrix = np.eye(4)
        text = node.find("c:matrix", NS)
        if text is not None and text.text:
            matrix = np.array(text.text.split(), dtype=float).reshape(4, 4)
        for instance in node.iterfind("c:instance_geometry", NS):
            for color, mesh in _triangles(geometries[instance.attrib["url"][1:]], colors):
                moved = mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3]
                result.append((color, Mesh(moved, mesh.faces)))
    return result


def _material_colors(root: ET.Element) -> dict[str, Rgb]:
    """Return the diffuse colour of every material id."""
    effects: dict[str, Rgb] = {}
    for effect in root.iterfind(".//c:effect", NS):
        color = effect.find(".//c:diffuse/c:color", NS)
        values = [float(v) for v in (color.text or "").split()] if color is not None else [1.0, 1.0, 1.0]
        effects[effect.attrib["id"]] = (values[0], values[1], values[2])
    materials = root.iterfind(".//c:material", NS)
    return {m.attrib["id"]: effects[m.find("c:instance_effect", NS).attrib["url"][1:]] for m in materials}


def _triangles(geometry: ET.Element, colors: dict[str, Rgb]) -> list[tuple[Rgb, Mesh]]:
    """Return one mesh for each `<triangles>` element of a geometry."""
    array = geometry.find(".//c:float_array", NS)
    points = np.array((array.text or "").split(), dtype=float).reshape(-1, 3)
    meshes = []
    for triangles in geometry.iterfind(".//c:triangles", NS):
        inputs = triangles.findall("c:input", NS)
        stride = 1 + max(int(i.attrib["offset"]) for i in inputs)
        offset = next(int(i.attrib["offset"]) for i in inputs if i.attrib["semantic"] == "VERTEX")
        flat = np.array((triangles.find("c:p", NS).text or "").split(), dtype=np.int64)
        faces = flat.reshape(-1, 3, stride)[:, :, offset]
        meshes.append((colors[triangles.attrib["material"]], Mesh(points, faces)))
    return meshes
