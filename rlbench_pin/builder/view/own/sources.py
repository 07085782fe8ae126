"""Where the meshes of a URDF file are looked for: in the archive that it came in, or in the folder of the task."""

from __future__ import annotations

import os
import posixpath
from collections.abc import Callable, Collection
from dataclasses import dataclass
from pathlib import Path

from rlbench_pin.builder.server import LARGEST_UPLOAD, Folder, UploadRefused

MESHES = (".obj", ".stl")
"""Endings of meshes that are taken."""
_MOST_FILES = 5000
_DEEPEST = 5


@dataclass(frozen=True)
class Source:
    """Files that a URDF file may name."""

    place: str
    """What it is, for errors: `the archive`, `the folder of the task`."""
    names: Collection[str]
    """Paths of the files that are there, with slashes."""
    read: Callable[[str], bytes]
    """Returns the content of one of them."""
    here: str = ""
    """Folder of the URDF file among them."""

    def find(self, urdf: str, said: str) -> str:
        """Return the file that a mesh element means.

        Args:
            urdf: Name of the URDF file, for errors.
            said: What the element says: a relative path, or `package://PACKAGE/PATH`.

        Raises:
            UploadRefused: There is none, it is of another kind, or there are several that it could be.
        """
        way = said.replace("\\", "/")
        scheme, mark, rest = way.partition("://")
        way = rest if mark else way
        if posixpath.splitext(way)[1].lower() not in MESHES:
            raise UploadRefused(urdf, f"it names the mesh '{said[:120]}'", "Give meshes as .obj or .stl files.")
        beside = posixpath.normpath(posixpath.join(self.here, way.lstrip("/")))
        if not mark and beside in self.names:
            return beside
        parts = [part for part in way.split("/") if part not in ("", ".", "..")]
        for first in range(len(parts)):
            end = "/".join(parts[first:])
            hits = sorted(name for name in self.names if name == end or name.endswith(f"/{end}"))
            if len(hits) == 1:
                return hits[0]
            if hits:
                raise UploadRefused(urdf, f"the mesh '{said[:120]}' could be {' or '.join(hits[:4])}", "Remove all but one.")
        there = ", ".join(sorted(self.names)[:8]) or "none"
        raise UploadRefused(urdf, f"the mesh '{said[:120]}' is not in {self.place}", f"Meshes there: {there}.")


def source_of_archive(files: dict[str, bytes], urdf: str) -> Source:
    """Return the files of an archive as seen from a URDF file in it."""
    return Source("the archive", files, files.__getitem__, posixpath.dirname(urdf))


def source_of_folder(root: Path) -> Source:
    """Return the meshes in a folder and those below it."""
    if not root.is_dir():
        return Source("the folder of the task", (), _nothing)
    folder, names = Folder(root), list[str]()
    for here, below, files in os.walk(folder.root):
        depth = len(Path(here).relative_to(folder.root).parts)
        below[:] = [name for name in below if not name.startswith(".") and depth < _DEEPEST]
        for name in files:
            if name.lower().endswith(MESHES) and not name.startswith("."):
                names.append((Path(here) / name).relative_to(folder.root).as_posix())
        if len(names) > _MOST_FILES:
            break

    def read(name: str) -> bytes:
        file = folder.path(name)
        with file.open("rb") as stream:
            return stream.read(LARGEST_UPLOAD + 1)

    return Source("the folder of the task", names, read)


def _nothing(name: str) -> bytes:
    raise FileNotFoundError(name)
