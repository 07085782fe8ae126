"""Uploaded files: bounded size, known format, content checked; ZIP archives are read in memory."""

from __future__ import annotations

import io
import lzma
import re
import stat
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import PurePosixPath

import numpy as np
import trimesh

from rlbench_pin.builder.server import MAX_UPLOAD_SIZE
from rlbench_pin.errors import RlbenchPinError

MAX_TRIANGLES = 200_000
"""Triangles of a mesh at most."""
MAX_FILES = 2000
"""Entries of an archive at most."""
MAX_CONTENT_SIZE = 4 * MAX_UPLOAD_SIZE
"""Unpacked size of all files of an archive at most [bytes]."""
_BROKEN = (zipfile.BadZipFile, zlib.error, lzma.LZMAError, OSError, EOFError, RuntimeError, NotImplementedError, ValueError)
_STEM = re.compile(r"[^a-z0-9_]+")


class UploadRefused(RlbenchPinError):
    """An uploaded file is refused."""

    def __init__(self, name: str, problem: str, hint: str = "") -> None:
        self.name, self.problem = name, problem
        super().__init__(f"'{name}' is refused: {problem}.{f' {hint}' if hint else ''}")


@dataclass(frozen=True, eq=False)
class UploadedMesh:
    """A mesh of an uploaded file."""

    name: str
    """Stem of the file name, in lower case."""
    mesh: trimesh.Trimesh


def upload_stem(name: str) -> str:
    """Return a file name without folder and ending, in lower case letters, digits and `_`."""
    stem = name.replace("\\", "/").rpartition("/")[2].rpartition(".")[0] or name
    stem = _STEM.sub("_", stem.lower()).strip("_")[:60]
    return stem if stem[:1].isalpha() else f"object_{stem}".rstrip("_")


def check_size(name: str, size: int) -> None:
    """Check the size of a file [bytes]. The server replaces a file that is too large by an empty one.

    Raises:
        UploadRefused: It is too large or empty.
    """
    if size > MAX_UPLOAD_SIZE or size == 0:
        hint = "Reduce it first, for instance with the decimation of Blender or MeshLab."
        raise UploadRefused(name, f"it is empty or larger than {MAX_UPLOAD_SIZE // 2**20} MB", hint)


def read_mesh(name: str, data: bytes) -> UploadedMesh:
    """Return the mesh of an OBJ or STL file; materials are ignored, no other file is opened.

    Raises:
        UploadRefused: It is too large, is not an OBJ or STL file, has no or too many triangles, or a vertex that is not finite.
    """
    check_size(name, len(data))
    ending = f".{name.rpartition('.')[2].lower()}"
    if ending not in (".obj", ".stl"):
        raise UploadRefused(name, f"its ending is '{ending}'", "Send a mesh as an .obj or .stl file.")
    _check_lines(name, ending, data)
    try:
        loaded = trimesh.load(
            io.BytesIO(data), file_type=ending[1:], force="mesh", process=False, skip_materials=ending == ".obj"
        )
    except Exception as error:  # whatever a parser raises on hostile bytes
        raise UploadRefused(
            name, f"it cannot be read as {ending[1:].upper()} ({type(error).__name__}: {str(error)[:120]})", "Export it again."
        ) from error
    if not isinstance(loaded, trimesh.Trimesh) or len(loaded.faces) == 0:
        raise UploadRefused(name, "it has no triangles", "Export it again with faces.")
    if len(loaded.faces) > MAX_TRIANGLES:
        raise UploadRefused(name, f"it has {len(loaded.faces)} triangles, the limit is {MAX_TRIANGLES}", "Reduce it first.")
    if not np.isfinite(loaded.vertices).all() or not np.abs(loaded.vertices).max() < 1e6:
        raise UploadRefused(name, "a vertex is not a finite number, or farther away than 1000 km", "Export it again.")
    loaded.merge_vertices()
    return UploadedMesh(upload_stem(name), loaded)


def _check_lines(name: str, ending: str, data: bytes) -> None:
    """Count triangles before anything is parsed."""
    if ending == ".obj":
        faces = data.count(b"\nf ") + data.startswith(b"f ")
        longest = max((len(line) for line in data.splitlines()), default=0)
        if longest > 100_000:
            raise UploadRefused(name, "a line has more than 100000 characters", "Export it again.")
    else:
        faces = int.from_bytes(data[80:84], "little") if not data.lstrip().startswith(b"solid") else data.count(b"endfacet")
        if b"facet" not in data[:1000] and (present := (len(data) - 84) // 50) < faces <= MAX_TRIANGLES:
            raise UploadRefused(name, f"it declares {faces} triangles, and has {max(present, 0)}", "Export it again.")
    if faces > MAX_TRIANGLES:
        raise UploadRefused(name, f"it has {faces} faces, the limit is {MAX_TRIANGLES}", "Reduce it first.")


def read_archive(name: str, data: bytes, endings: tuple[str, ...]) -> dict[str, bytes]:
    """Return the files of some formats in a ZIP archive, by their paths. Nothing is written to the disk.

    Args:
        name: Name of the archive.
        data: Content of the archive.
        endings: Wanted files, such as `.obj`; others are not unpacked.

    Raises:
        UploadRefused: It is not a ZIP file, is too large or encrypted, or has links or paths outside of itself.
    """
    check_size(name, len(data))
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            entries = _wanted(name, archive, endings)
            return _contents(name, archive, entries)
    except _BROKEN as error:
        problem = f"it cannot be read as a zip file ({type(error).__name__}: {str(error)[:120]})"
        raise UploadRefused(name, problem, "Create it again.") from error


def _wanted(name: str, archive: zipfile.ZipFile, endings: tuple[str, ...]) -> dict[str, zipfile.ZipInfo]:
    """Check all entries, and return the wanted ones by their paths."""
    infos = archive.infolist()
    if len(infos) > MAX_FILES:
        raise UploadRefused(name, f"it has {len(infos)} files, the limit is {MAX_FILES}", "Remove some.")
    found: dict[str, zipfile.ZipInfo] = {}
    for info in infos:
        path = _checked_path(name, info)
        if info.is_dir() or any(part.startswith((".", "__MACOSX")) for part in path.parts):
            continue
        if path.suffix.lower() in endings:
            if str(path) in found:
                raise UploadRefused(name, f"it has '{path}' twice", "Remove one of them.")
            found[str(path)] = info
    if sum(info.file_size for info in found.values()) > MAX_CONTENT_SIZE:
        raise UploadRefused(name, f"its files have more than {MAX_CONTENT_SIZE // 2**20} MB unpacked", "Remove some.")
    return found


def _checked_path(name: str, info: zipfile.ZipInfo) -> PurePosixPath:
    """Return the path of an entry; refuse links and paths outside of the archive."""
    filename = info.filename
    path = PurePosixPath(filename.replace("\\", "/"))
    if path.is_absolute() or ".." in path.parts or ":" in filename or any(ord(letter) < 32 for letter in filename):
        raise UploadRefused(name, f"it names '{filename[:80]}', which is outside of it", "Create it again from one folder.")
    if stat.S_ISLNK(info.external_attr >> 16):
        raise UploadRefused(name, f"'{filename[:80]}' is a link", "Replace it by the file.")
    if info.flag_bits & 1:
        raise UploadRefused(name, f"'{filename[:80]}' is encrypted", "Create it again without a password.")
    return path


def _contents(name: str, archive: zipfile.ZipFile, entries: dict[str, zipfile.ZipInfo]) -> dict[str, bytes]:
    """Unpack entries; their declared sizes are not trusted."""
    contents: dict[str, bytes] = {}
    left = MAX_CONTENT_SIZE
    for path, info in entries.items():
        with archive.open(info) as stream:
            contents[path] = stream.read(min(left, MAX_UPLOAD_SIZE) + 1)
        left -= len(contents[path])
        if left < 0 or len(contents[path]) > MAX_UPLOAD_SIZE:
            problem = f"'{path}' is too large unpacked: the limit is {MAX_UPLOAD_SIZE // 2**20} MB per file"
            raise UploadRefused(name, problem, "Reduce it first.")
    return contents
