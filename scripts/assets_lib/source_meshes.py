"""Paths of the files of other packages, and triangles of their STL and OBJ files; other parts of the formats are ignored."""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from assets_lib.dae import Rgb
from assets_lib.mesh import Mesh


def example_folder(name: str) -> Path:
    """Return the folder of a robot of example-robot-data, next to the installed cmeel packages."""
    spec = importlib.util.find_spec("cmeel") or importlib.util.find_spec("numpy")
    assert spec is not None and spec.origin is not None
    return Path(spec.origin).parents[1] / "cmeel.prefix/share/example-robot-data/robots" / name


def read_stl(path: Path) -> Mesh:
    """Return the mesh of a binary STL file [m], corners not welded."""
    raw = path.read_bytes()
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("pad", "<u2")])
    corners = np.frombuffer(raw[84:], dtype=record)["corners"].reshape(-1, 3).astype(float)
    return Mesh(corners, np.arange(len(corners)).reshape(-1, 3))


def read_obj(path: Path, paints: Mapping[str, Rgb] | None = None, scale: float = 1.0) -> list[tuple[Rgb, Mesh]]:
    """Return the meshes of an OBJ file of triangles [m], one for each material.

    Args:
        path: The file.
        paints: The colour of each material, by the part of its name before a point; without it there is one white mesh.
        scale: Length of its unit [m].
    """
    points: list[list[str]] = []
    faces: dict[str, list[list[int]]] = {}
    material = ""
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            points.append(words[1:4])
        elif words[:1] == ["usemtl"] and paints is not None:
            material = words[1].split(".")[0]
        elif words[:1] == ["f"]:
            faces.setdefault(material, []).append([int(word.split("/")[0]) - 1 for word in words[1:]])
    vertices = scale * np.array(points, dtype=float)
    white = (1.0, 1.0, 1.0)
    return [(white if paints is None else paints[name], Mesh(vertices, np.array(own))) for name, own in faces.items()]
