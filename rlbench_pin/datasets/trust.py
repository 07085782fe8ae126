"""Checks of episode files before they are opened: the SHA-256 in a manifest, or a read in a subprocess first."""

from __future__ import annotations

import json
import math
import os
import select
import signal
import subprocess
import sys
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from types import TracebackType

from rlbench_pin.datasets.layout import MANIFEST, is_episode_place
from rlbench_pin.datasets.manifest import file_digest, journal_path, read_manifest
from rlbench_pin.errors import DatasetError, EpisodeFileError
from rlbench_pin.values import as_names, as_number

_CHILD = Path(__file__).with_name("inspection_child.py")
_SECONDS = 15.0
_SECONDS_PER_BYTE = 1e-6
_ENDING = 5.0  # [s]
_Stamp = tuple[int, int, int] | None


class Inspector:
    """A subprocess that reads files before this process does. Use it in a `with` block; it starts at the first file.

    Damaged files can crash the HDF5 library, or make it loop for ever. A file in a manifest is checked by its SHA-256; any other
    file is read by this subprocess first.

    Args:
        command: Command line of the subprocess, which answers each line with a line.
        seconds: Time limit for a file [s]; one microsecond is added for each of its bytes.
    """

    def __init__(self, command: tuple[str, ...] = (sys.executable, "-P", str(_CHILD)), seconds: float = _SECONDS) -> None:
        self._command, self._seconds = as_names(command, "command"), as_number(seconds, "seconds", above=0.0, most=1e9)
        self._process: subprocess.Popen[bytes] | None = None

    def inspect(self, path: Path) -> None:
        """Let the subprocess read a file.

        Raises:
            EpisodeFileError: The subprocess crashed or exceeded the time limit.
        """
        seconds = self._seconds + _SECONDS_PER_BYTE * path.stat().st_size
        try:
            answered = self._ask(path, seconds)
        except OSError as error:
            raise EpisodeFileError(path, f"'{path}' could not be examined before it is read: {error}. Try it again.") from error
        if answered:
            return
        code = self._end()
        if code is None:
            problem = f"reading it did not end within {seconds:.0f} s"
        else:
            problem = f"reading it ended a process with {signal.Signals(-code).name if code < 0 else f'exit code {code}'}"
        raise EpisodeFileError(path, f"The episode '{path}' is damaged or harmful: {problem}. Delete it and record it again.")

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._end()

    def __enter__(self) -> Inspector:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def _ask(self, path: Path, seconds: float) -> bool:
        """Return whether the process has answered in time."""
        if self._process is None:
            self._process = subprocess.Popen(
                self._command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
                start_new_session=True,
            )
        assert self._process.stdin is not None and self._process.stdout is not None
        with suppress(BrokenPipeError):
            self._process.stdin.write(json.dumps([os.path.abspath(path), math.ceil(seconds) + 5]).encode() + b"\n")
            self._process.stdin.flush()
            ready, _, _ = select.select([self._process.stdout], [], [], seconds)
            return bool(ready) and self._process.stdout.readline() != b""
        return False

    def _end(self) -> int | None:
        """End the process. Return its exit code if it had ended by itself, else None."""
        process, self._process = self._process, None
        assert process is not None
        code = process.poll()
        if code is None and process.stdout is not None and select.select([process.stdout], [], [], 0.0)[0]:
            with suppress(subprocess.TimeoutExpired):
                code = process.wait(_ENDING)  # its output is closed
        process.kill()
        with suppress(BrokenPipeError):
            process.communicate()
        return code


@lru_cache(maxsize=4096)
def _inspect(path: Path, stamp: _Stamp) -> None:
    """Let a subprocess read a file; again only after the file has changed."""
    with Inspector() as inspector:
        inspector.inspect(path)


def check_file(path: Path, sha256: str | None = None, inspector: Inspector | None = None) -> None:
    """Check that a file can be opened: its SHA-256 equals that in its manifest, or a subprocess has read it without a crash.

    Args:
        path: An episode file.
        sha256: Expected SHA-256; None takes it from the manifest of the dataset that contains the file.
        inspector: Reads a file that no manifest lists. None starts a subprocess for that.

    Raises:
        EpisodeFileError: The file differs from its manifest, or reading it crashes or hangs.
    """
    sha256 = listed_digest(path) if sha256 is None else sha256
    if sha256 is not None:
        if _digest(path, file_stamp(path)) != sha256:
            raise altered(path)
    elif inspector is not None:
        inspector.inspect(path)
    else:
        _inspect(path, file_stamp(path))


def altered(path: Path) -> EpisodeFileError:
    """Return the error of a file that differs from its manifest."""
    return EpisodeFileError(
        path, f"'{path}' is not the file its manifest describes: the SHA-256 differs. Delete it and record it again."
    )


def listed_digest(path: Path) -> str | None:
    """Return the SHA-256 of a file in the manifest of its dataset; None if no manifest lists it."""
    path = Path(os.path.abspath(path))
    if not is_episode_place(path):
        return None
    folder = path.parents[2]
    manifest = folder / MANIFEST
    stamps = file_stamp(manifest), file_stamp(journal_path(manifest))
    if stamps == (None, None):
        return None
    return _listed(folder, *stamps).get(path.relative_to(folder).as_posix())


@lru_cache(maxsize=16)
def _listed(folder: Path, manifest: _Stamp, journal: _Stamp) -> dict[str, str]:
    """Return file -> SHA-256 of a manifest; empty if it is damaged or of another task."""
    try:
        return {entry.file: entry.sha256 for entry in read_manifest(folder.parent, folder.name)}
    except DatasetError:
        return {}


@lru_cache(maxsize=65536)
def _digest(path: Path, stamp: _Stamp) -> str:
    return file_digest(path)


def file_stamp(path: Path) -> _Stamp:
    """Return inode, size and modification time of a file; None if it does not exist."""
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_ino, status.st_size, status.st_mtime_ns
