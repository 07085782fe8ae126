"""The SHA-256 that the manifest of a dataset has for a file, wherever the path of the file came from."""

from __future__ import annotations

import os
from functools import lru_cache
from pathlib import Path

from rlbench_pin.datasets.layout import MANIFEST, is_episode_place
from rlbench_pin.datasets.manifest import file_digest, journal_path, read_manifest
from rlbench_pin.datasets.trust.inspection import Inspector, inspect_once
from rlbench_pin.errors import DatasetError, EpisodeFileError

_Stamp = tuple[int, int, int] | None


def check_file(path: Path, inspector: Inspector | None = None) -> None:
    """Make sure that a file can be opened: it is what its manifest lists, or another process has survived reading it.

    Args:
        path: An episode file.
        inspector: Reads a file that no manifest lists; a process of its own does when None.

    Raises:
        EpisodeFileError: It is another file than the manifest describes, or reading it crashes or hangs.
    """
    sha256 = listed_digest(path)
    if sha256 is not None:
        check_digest(path, sha256)
    elif inspector is not None:
        inspector.inspect(path)
    else:
        inspect_once(path)


def check_digest(path: Path, sha256: str) -> None:
    """Raise EpisodeFileError unless the bytes of a file add up to `sha256`."""
    if _digest(path, _stamp(path)) != sha256:
        raise altered(path)


def altered(path: Path) -> EpisodeFileError:
    """Return the error of a file that is not what its manifest lists."""
    return EpisodeFileError(
        path, f"'{path}' is not the file its manifest describes: the SHA-256 differs. Delete it and record it again."
    )


def listed_digest(path: Path) -> str | None:
    """Return the SHA-256 that the manifest of a dataset has for a file, None where no manifest lists it."""
    path = Path(os.path.abspath(path))
    if not is_episode_place(path):
        return None
    folder = path.parents[2]
    manifest = folder / MANIFEST
    stamps = _stamp(manifest), _stamp(journal_path(manifest))
    if stamps == (None, None):
        return None
    return _listed(folder, *stamps).get(path.relative_to(folder).as_posix())


@lru_cache(maxsize=16)
def _listed(folder: Path, manifest: _Stamp, journal: _Stamp) -> dict[str, str]:
    """Read a manifest; one that is damaged, or of another task, lists nothing that could be believed."""
    try:
        return {entry.file: entry.sha256 for entry in read_manifest(folder.parent, folder.name)}
    except DatasetError:
        return {}


@lru_cache(maxsize=65536)
def _digest(path: Path, stamp: _Stamp) -> str:
    return file_digest(path)


def _stamp(path: Path) -> _Stamp:
    """Return what changes with a file, None where there is none."""
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_ino, status.st_size, status.st_mtime_ns
