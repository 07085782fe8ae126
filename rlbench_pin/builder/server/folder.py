"""The folder of a task: what the browser names lies in it, or is refused."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path, PurePosixPath, PureWindowsPath

from rlbench_pin.builder.server.errors import OutsideFolder
from rlbench_pin.errors import StorageError
from rlbench_pin.values import as_path


class Folder:
    """The one folder into which a builder writes.

    Args:
        root: The folder; it exists.
    """

    def __init__(self, root: Path) -> None:
        self.root = as_path(root, "root").resolve(strict=True)

    def path(self, name: str) -> Path:
        """Return the file of that name inside the folder.

        Args:
            name: Relative, with slashes.

        Raises:
            OutsideFolder: It is absolute, goes upwards, is hidden, or a link on its way leads out.
        """
        self._check(name)
        file = self.root / name
        resolved = Path(os.path.realpath(file))
        if resolved != self.root and self.root not in resolved.parents:
            raise OutsideFolder(name, "leads out of the folder of the task")
        return resolved

    def _check(self, name: str) -> None:
        if not isinstance(name, str) or not name.strip():
            raise OutsideFolder(str(name), "is no name of a file")
        if PurePosixPath(name).is_absolute() or PureWindowsPath(name).drive or PureWindowsPath(name).root:
            raise OutsideFolder(name, "is absolute")
        parts = name.replace("\\", "/").split("/")
        if any(part == ".." for part in parts):
            raise OutsideFolder(name, "goes upwards")
        if any(ord(letter) < 32 for letter in name) or len(name) > 255:
            raise OutsideFolder(name[:80], "has letters that no file name has, or too many of them")
        if any(part.startswith(".") for part in parts if part != "."):
            raise OutsideFolder(name, "is hidden")

    def write_all(self, name: str, files: Mapping[str, bytes]) -> Path:
        """Write a new folder with files in it: all of them, or none.

        Raises:
            OutsideFolder: It or a file of it lies elsewhere.
            StorageError: It cannot be written, or something of that name is there.
        """
        wanted = self.path(name)
        try:
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
        except OSError as error:
            raise StorageError(wanted, error) from error
        return wanted

    def write(self, name: str, data: bytes) -> Path:
        """Write a file inside the folder: whole, or not at all.

        Raises:
            OutsideFolder: It lies elsewhere.
            StorageError: It cannot be written.
        """
        file = self.path(name)
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            self.path(name)  # what was made on the way is inside, too
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
        except OSError as error:
            raise StorageError(file, error) from error
        return file
