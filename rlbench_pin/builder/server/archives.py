"""Zip files that a browser sends: read in memory, within bounds, never unpacked by the paths that they name."""

from __future__ import annotations

import io
import lzma
import stat
import zipfile
import zlib
from pathlib import PurePosixPath

from rlbench_pin.builder.server.errors import UploadRefused
from rlbench_pin.builder.server.uploads import LARGEST_UPLOAD, check_size

MOST_FILES = 2000
"""Entries of an archive."""
LARGEST_CONTENT = 4 * LARGEST_UPLOAD
"""What all files of an archive have together, unpacked [bytes]."""
_BROKEN = (zipfile.BadZipFile, zlib.error, lzma.LZMAError, OSError, EOFError, RuntimeError, NotImplementedError, ValueError)


def read_archive(name: str, data: bytes, endings: tuple[str, ...]) -> dict[str, bytes]:
    """Return the files of some kinds in a zip file, by their paths in it.

    Args:
        name: Of the archive.
        data: Its content.
        endings: Of the files that are wanted, such as `.obj`; others are not unpacked.

    Raises:
        UploadRefused: It is no zip file, is too large unpacked, is locked, or names paths outside of itself or links.
    """
    check_size(name, len(data))
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            entries = _wanted(name, archive, endings)
            return _contents(name, archive, entries)
    except _BROKEN as error:
        raise UploadRefused(name, f"it cannot be read as a zip file ({type(error).__name__}: {str(error)[:120]})") from error


def _wanted(name: str, archive: zipfile.ZipFile, endings: tuple[str, ...]) -> dict[str, zipfile.ZipInfo]:
    """Return the entries that are wanted, by their paths, after looking at all."""
    infos = archive.infolist()
    if len(infos) > MOST_FILES:
        raise UploadRefused(name, f"it has {len(infos)} files, at most {MOST_FILES} are taken")
    found: dict[str, zipfile.ZipInfo] = {}
    for info in infos:
        path = _checked_path(name, info)
        if info.is_dir() or any(part.startswith((".", "__MACOSX")) for part in path.parts):
            continue
        if path.suffix.lower() in endings:
            if str(path) in found:
                raise UploadRefused(name, f"it has '{path}' twice")
            found[str(path)] = info
    if sum(info.file_size for info in found.values()) > LARGEST_CONTENT:
        raise UploadRefused(name, f"its files have more than {LARGEST_CONTENT // 2**20} MB unpacked")
    return found


def _checked_path(name: str, info: zipfile.ZipInfo) -> PurePosixPath:
    """Return the path of an entry, which lies in the archive and is no link."""
    said = info.filename
    path = PurePosixPath(said.replace("\\", "/"))
    if path.is_absolute() or ".." in path.parts or ":" in said or any(ord(letter) < 32 for letter in said):
        raise UploadRefused(name, f"it names '{said[:80]}', which lies outside of it", "Make it anew from one folder.")
    if stat.S_ISLNK(info.external_attr >> 16):
        raise UploadRefused(name, f"'{said[:80]}' is a link", "Put the file itself in its place.")
    if info.flag_bits & 1:
        raise UploadRefused(name, f"'{said[:80]}' is locked with a password")
    return path


def _contents(name: str, archive: zipfile.ZipFile, entries: dict[str, zipfile.ZipInfo]) -> dict[str, bytes]:
    """Unpack entries, however much they say that they have."""
    contents: dict[str, bytes] = {}
    left = LARGEST_CONTENT
    for path, info in entries.items():
        with archive.open(info) as stream:
            contents[path] = stream.read(min(left, LARGEST_UPLOAD) + 1)
        left -= len(contents[path])
        if left < 0 or len(contents[path]) > LARGEST_UPLOAD:
            raise UploadRefused(name, f"'{path}' is too large unpacked: {LARGEST_UPLOAD // 2**20} MB a file are taken")
    return contents
