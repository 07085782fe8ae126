"""Write numbers, OBJ and PNG files so that the same input gives byte-identical files."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from assets_lib.mesh import FloatArray, Mesh, corner_normals


def number(value: float, digits: int = 6) -> str:
    """Format a number with fixed rounding, without trailing zeros or a negative zero."""
    text = f"{float(value):.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in ("", "-0") else text


def significant(value: float) -> str:
    """Format a number with six significant digits (masses, inertias)."""
    text = f"{float(value):.6g}"
    return "0" if float(text) == 0.0 else text


def numbers(values: Iterable[float], digits: int = 6) -> str:
    """Format several numbers, separated by blanks."""
    return " ".join(number(value, digits) for value in values)


def obj_text(
    mesh: Mesh,
    *,
    crease: float | None,
    texture: str | None = None,
    normals: FloatArray | None = None,
    shades: FloatArray | None = None,
) -> str:
    """Return a mesh as OBJ.

    Args:
        mesh: The mesh; its `uv` are written when there is a texture.
        crease: Angle below which neighbouring faces are shaded smoothly [rad]; None writes no normals (collision).
        texture: Name of the MTL file and material, without ending.
        normals: Of the corners of the faces, shape (m, 3, 3), in place of those of the mesh.
        shades: How much light reaches the corners of the faces (m, 3), written as colours of the vertices.
    """
    if crease is not None and normals is None:
        normals = corner_normals(mesh, crease)
    ends = [""] * len(mesh.vertices)
    if shades is not None and shades.min() < 1.0:
        mesh, shade = _split(mesh, shades)
        ends = [f" {text} {text} {text}" for text in map(number, shade)]
    lines = ["# made by scripts/build_assets.py"]
    if texture is not None:
        lines += [f"mtllib {texture}.mtl", f"usemtl {texture}"]
    lines += [f"v {numbers(v, 5)}{end}" for v, end in zip(mesh.vertices, ends, strict=True)]
    if mesh.uv is not None:
        lines += [f"vt {numbers(v, 4)}" for v in mesh.uv]
    if normals is None:
        lines += ["f {} {} {}".format(*(face + 1)) for face in mesh.faces]
        return "\n".join(lines) + "\n"
    rows = [numbers(n, 3) for n in normals.reshape(-1, 3)]
    order = {row: i + 1 for i, row in enumerate(dict.fromkeys(rows))}
    lines += [f"vn {row}" for row in order]
    for face, corners in enumerate(mesh.faces.tolist()):
        words = []
        for k, corner in enumerate(corners):
            middle = str(corner + 1) if mesh.uv is not None else ""
            words.append(f"{corner + 1}/{middle}/{order[rows[3 * face + k]]}")
        lines.append("f " + " ".join(words))
    return "\n".join(lines) + "\n"


def _split(mesh: Mesh, shades: FloatArray) -> tuple[Mesh, FloatArray]:
    """Return a mesh with a vertex for each shade (m, 3) that a vertex has in its faces, and the shades of these."""
    pairs = np.column_stack([mesh.faces.ravel(), np.round(shades.ravel() * 1000.0).astype(np.int64)])
    own, faces = np.unique(pairs, axis=0, return_inverse=True)
    uv = None if mesh.uv is None else mesh.uv[own[:, 0]]
    return Mesh(mesh.vertices[own[:, 0]], faces.reshape(-1, 3), uv), own[:, 1] / 1000.0


def mtl_text(texture: str) -> str:
    """Return a material file that shows `<texture>.png`."""
    return f"newmtl {texture}\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nmap_Kd {texture}.png\n"


def png_bytes(image: NDArray[np.uint8]) -> bytes:
    """Return an RGB image (h, w, 3) as PNG; stored with our own filter choice, so no library version matters."""
    height, width, _ = image.shape
    rows = b"".join(b"\x00" + image[y].tobytes() for y in range(height))
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = ((b"IHDR", head), (b"IDAT", zlib.compress(rows, 9)), (b"IEND", b""))
    body = b"".join(struct.pack(">I", len(d)) + k + d + struct.pack(">I", zlib.crc32(k + d)) for k, d in chunks)
    return b"\x89PNG\r\n\x1a\n" + body


def write_text(path: Path, text: str) -> None:
    """Write a text file with Unix line ends, making its folder."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(text.encode("utf-8"))
