"""Files that a browser sends: of bounded size, of a known kind, and what they say they are."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass

import numpy as np
import trimesh

from rlbench_pin.builder.server.errors import UploadRefused

LARGEST_UPLOAD = 64 * 1024 * 1024
"""A file at most [bytes]."""
MOST_TRIANGLES = 200_000
"""Of a mesh."""
_STEM = re.compile(r"[^a-z0-9_]+")


@dataclass(frozen=True, eq=False)
class UploadedMesh:
    """A mesh that was sent."""

    name: str
    """Stem of its file, in small letters."""
    mesh: trimesh.Trimesh
    """What it holds."""


def upload_stem(name: str) -> str:
    """Return the name of a sent file without folder and ending, in small letters, digits and `_`."""
    stem = name.replace("\\", "/").rpartition("/")[2].rpartition(".")[0] or name
    stem = _STEM.sub("_", stem.lower()).strip("_")[:60]
    return stem if stem[:1].isalpha() else f"thing_{stem}".rstrip("_")


def check_size(name: str, size: int) -> None:
    """Refuse a file that is too large or empty.

    Raises:
        UploadRefused: It is.
    """
    if size > LARGEST_UPLOAD:
        hint = "Reduce it first, for instance with the decimation of Blender or MeshLab."
        raise UploadRefused(name, f"it has {size / 2**20:.0f} MB, at most {LARGEST_UPLOAD // 2**20} MB are taken", hint)
    if size == 0:
        raise UploadRefused(name, "it is empty")


def read_mesh(name: str, data: bytes) -> UploadedMesh:
    """Return the mesh in a file that was sent; materials are left out, no other file is opened.

    Raises:
        UploadRefused: It is too large, no OBJ or STL file, has no triangles or too many, or a corner that is no number.
    """
    check_size(name, len(data))
    ending = f".{name.rpartition('.')[2].lower()}"
    if ending not in (".obj", ".stl"):
        raise UploadRefused(name, f"a mesh is an .obj or .stl file, not '{ending}'")
    _check_lines(name, ending, data)
    try:
        loaded = trimesh.load(
            io.BytesIO(data), file_type=ending[1:], force="mesh", process=False, skip_materials=ending == ".obj"
        )
    except Exception as error:  # whatever a parser raises on hostile bytes
        raise UploadRefused(
            name, f"it cannot be read as {ending[1:].upper()} ({type(error).__name__}: {str(error)[:120]})"
        ) from error
    if not isinstance(loaded, trimesh.Trimesh) or len(loaded.faces) == 0:
        raise UploadRefused(name, "it has no triangles")
    if len(loaded.faces) > MOST_TRIANGLES:
        raise UploadRefused(name, f"it has {len(loaded.faces)} triangles, at most {MOST_TRIANGLES} are taken", "Reduce it first.")
    if not np.isfinite(loaded.vertices).all() or not np.abs(loaded.vertices).max() < 1e6:
        raise UploadRefused(name, "a corner is no number, or farther away than 1000 km")
    loaded.merge_vertices()
    return UploadedMesh(upload_stem(name), loaded)


def _check_lines(name: str, ending: str, data: bytes) -> None:
    """Count triangles before anything is parsed."""
    if ending == ".obj":
        faces = data.count(b"\nf ") + data.startswith(b"f ")
        longest = max((len(line) for line in data.splitlines()), default=0)
        if longest > 100_000:
            raise UploadRefused(name, "a line has more than 100000 letters")
    else:
        faces = int.from_bytes(data[80:84], "little") if not data.lstrip().startswith(b"solid") else data.count(b"endfacet")
        if b"facet" not in data[:1000] and (here := (len(data) - 84) // 50) < faces <= MOST_TRIANGLES:
            raise UploadRefused(name, f"it says that it has {faces} triangles, and has {max(here, 0)}", "Export it again.")
    if faces > MOST_TRIANGLES:
        raise UploadRefused(name, f"it has {faces} faces, at most {MOST_TRIANGLES} are taken", "Reduce it first.")
