"""Trust in episode files: a SHA-256 that a manifest lists, or another process that survives reading them first."""

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
    """A process that reads files before this one does; use it in a `with` block. It starts with the first file.

    The HDF5 library does not survive every damaged file: one flipped bit can crash it, zeros can make it loop for ever. Where a
    manifest lists a file, its SHA-256 says whether it is still as it was written; any other file goes through this.

    Args:
        command: What is started; it answers each line with a line.
        seconds: How long it may take for a file, beside a microsecond for each of its bytes [s].
    """

    def __init__(self, command: tuple[str, ...] = (sys.executable, "-P", str(_CHILD)), seconds: float = _SECONDS) -> None:
        self._command, self._seconds = as_names(command, "command"), as_number(seconds, "seconds", above=0.0, most=1e9)
        self._process: subprocess.Popen[bytes] | None = None

    def inspect(self, path: Path) -> None:
        """Let the process read a file.

        Raises:
            EpisodeFileError: It did not survive that, or did not finish in time.
        """
        seconds = self._seconds + _SECONDS_PER_BYTE * path.stat().st_size
        try:
            answered = self._ask(path, seconds)
        except OSError as error:
            raise EpisodeFileError(path, f"'{path}' could not be examined before it is read: {error}.") from error
        if answered:
            return
        code = self._end()
        if code is None:
            problem = f"reading it did not end within {seconds:.0f} s"
        else:
            problem = f"reading it ended a process with {signal.Signals(-code).name if code < 0 else f'exit code {code}'}"
        raise EpisodeFileError(
            path, f"The episode '{path}' is damaged, or made to do harm: {problem}. Delete it and record it again."
        )

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
        """End the process and return the code that it had ended with by itself, None when it had not."""
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


def inspect_once(path: Path) -> None:
    """Let another process read a file, once for as long as it does not change.

    Raises:
        EpisodeFileError: It did not survive that, or did not finish in time.
    """
    _inspect(path, file_stamp(path))


@lru_cache(maxsize=4096)
def _inspect(path: Path, stamp: _Stamp) -> None:
    with Inspector() as inspector:
        inspector.inspect(path)


def check_file(path: Path, sha256: str | None = None, inspector: Inspector | None = None) -> None:
    """Make sure that a file can be opened: it is what its manifest lists, or another process has survived reading it.

    Args:
        path: An episode file.
        sha256: Expected checksum; None looks it up in the manifest of the dataset that the file lies in.
        inspector: Reads a file that no manifest lists; a process of its own does when None.

    Raises:
        EpisodeFileError: It is another file than the manifest describes, or reading it crashes or hangs.
    """
    sha256 = listed_digest(path) if sha256 is None else sha256
    if sha256 is not None:
        if _digest(path, file_stamp(path)) != sha256:
            raise altered(path)
    elif inspector is not None:
        inspector.inspect(path)
    else:
        inspect_once(path)


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
    stamps = file_stamp(manifest), file_stamp(journal_path(manifest))
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


def file_stamp(path: Path) -> _Stamp:
    """Return what changes with a file, None where there is none."""
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_ino, status.st_size, status.st_mtime_ns
