"""Files in the folder of a task: paths are checked to be inside; meshes of a URDF file are searched there."""

from __future__ import annotations

import os
import posixpath
import shutil
import tempfile
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath, PureWindowsPath

from rlbench_pin.builder.custom_assets.uploads import UploadRefused
from rlbench_pin.builder.server import MAX_UPLOAD_SIZE
from rlbench_pin.errors import RlbenchPinError, storing
from rlbench_pin.values import as_path

MESHES = (".obj", ".stl")
"""Endings of mesh files."""
_MAX_FILES = 5000
_MAX_DEPTH = 5


class OutsideFolder(RlbenchPinError):
    """A path given by the browser is not inside the folder of the task."""

    def __init__(self, path: str, problem: str) -> None:
        self.path, self.problem = path, problem
        super().__init__(f"'{path}' {problem}. Give a path inside the folder of the task, such as 'meshes/handle.obj'.")


class Folder:
    """The folder of a task. The builder writes nowhere else.

    Args:
        root: An existing folder.
    """

    def __init__(self, root: Path) -> None:
        self.root = as_path(root, "root").resolve(strict=True)

    def path(self, name: str) -> Path:
        """Return a file inside the folder.

        Args:
            name: Relative path with slashes.

        Raises:
            OutsideFolder: It is absolute, goes upwards, is hidden, or leads out of the folder through a link.
        """
        self._check(name)
        file = self.root / name
        resolved = Path(os.path.realpath(file))
        if resolved != self.root and self.root not in resolved.parents:
            raise OutsideFolder(name, "leads out of the folder of the task")
        return resolved

    def _check(self, name: str) -> None:
        if not isinstance(name, str) or not name.strip():
            raise OutsideFolder(str(name), "is not a file name")
        if PurePosixPath(name).is_absolute() or PureWindowsPath(name).drive or PureWindowsPath(name).root:
            raise OutsideFolder(name, "is absolute")
        parts = name.replace("\\", "/").split("/")
        if any(part == ".." for part in parts):
            raise OutsideFolder(name, "goes upwards")
        if any(ord(letter) < 32 for letter in name) or len(name) > 255:
            raise OutsideFolder(name[:80], "has characters that no file name has, or too many")
        if any(part.startswith(".") for part in parts if part != "."):
            raise OutsideFolder(name, "is hidden")

    def write_all(self, name: str, files: Mapping[str, bytes]) -> Path:
        """Write a new folder with files atomically.

        Raises:
            OutsideFolder: A path is outside the folder.
            StorageError: It cannot be written, or the name exists.
        """
        wanted = self.path(name)
        with storing(wanted):
            temporary = Path(tempfile.mkdtemp(prefix=f".{wanted.name}.", dir=self.root))
            try:
                inside = Folder(temporary)
                for file, content in files.items():
                    inside.write(file, content)
                temporary.chmod(0o755)
                temporary.rename(wanted)
            except BaseException:
                shutil.rmtree(temporary, ignore_errors=True)
                raise
        return wanted

    def write(self, name: str, data: bytes) -> Path:
        """Write a file atomically.

        Raises:
            OutsideFolder: It is outside the folder.
            StorageError: It cannot be written.
        """
        file = self.path(name)
        with storing(file):
            file.parent.mkdir(parents=True, exist_ok=True)
            self.path(name)  # the new parent folders are inside, too
            handle, temporary = tempfile.mkstemp(prefix=f".{file.name}.", dir=file.parent)
            try:
                with os.fdopen(handle, "wb") as stream:
                    stream.write(data)
                    stream.flush()
                    os.fsync(stream.fileno())
                Path(temporary).chmod(0o644)
                os.replace(temporary, file)
            except BaseException:
                Path(temporary).unlink(missing_ok=True)
                raise
        return file


@dataclass(frozen=True)
class MeshSource:
    """The meshes that a URDF file may name."""

    place: str
    """Name of the place in messages: `the archive`, `the folder of the task`."""
    names: Collection[str]
    """Paths of the files, with slashes."""
    read: Callable[[str], bytes]
    """Returns the content of one of them."""
    base: str = ""
    """Folder of the URDF file."""

    def find(self, urdf: str, filename: str) -> str:
        """Return the file that a mesh element names.

        Args:
            urdf: Name of the URDF file, for errors.
            filename: A relative path, or `package://PACKAGE/PATH`.

        Raises:
            UploadRefused: The file is missing, ambiguous, or of another format.
        """
        path = filename.replace("\\", "/")
        scheme, mark, rest = path.partition("://")
        path = rest if mark else path
        if posixpath.splitext(path)[1].lower() not in MESHES:
            raise UploadRefused(urdf, f"it names the mesh '{filename[:120]}'", "Give meshes as .obj or .stl files.")
        beside = posixpath.normpath(posixpath.join(self.base, path.lstrip("/")))
        if not mark and beside in self.names:
            return beside
        parts = [part for part in path.split("/") if part not in ("", ".", "..")]
        for first in range(len(parts)):
            end = "/".join(parts[first:])
            hits = sorted(name for name in self.names if name == end or name.endswith(f"/{end}"))
            if len(hits) == 1:
                return hits[0]
            if hits:
                raise UploadRefused(urdf, f"the mesh '{filename[:120]}' could be {' or '.join(hits[:4])}", "Remove all but one.")
        there = ", ".join(sorted(self.names)[:8]) or "none"
        raise UploadRefused(urdf, f"the mesh '{filename[:120]}' is not in {self.place}", f"Meshes there: {there}.")


def archive_meshes(files: dict[str, bytes], urdf: str) -> MeshSource:
    """Return the files of an archive for a URDF file in it."""
    return MeshSource("the archive", files, files.__getitem__, posixpath.dirname(urdf))


def folder_meshes(root: Path) -> MeshSource:
    """Return the meshes in a folder and its subfolders."""
    if not root.is_dir():
        return MeshSource("the folder of the task", (), _nothing)
    folder, names = Folder(root), list[str]()
    for here, below, files in os.walk(folder.root):
        depth = len(Path(here).relative_to(folder.root).parts)
        below[:] = [name for name in below if not name.startswith(".") and depth < _MAX_DEPTH]
        for name in files:
            if name.lower().endswith(MESHES) and not name.startswith("."):
                names.append((Path(here) / name).relative_to(folder.root).as_posix())
        if len(names) > _MAX_FILES:
            break

    def read(name: str) -> bytes:
        file = folder.path(name)
        with file.open("rb") as stream:
            return stream.read(MAX_UPLOAD_SIZE + 1)

    return MeshSource("the folder of the task", names, read)


def _nothing(name: str) -> bytes:
    raise FileNotFoundError(name)
