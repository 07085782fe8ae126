"""Conversion of an uploaded file to an asset, in a subprocess with bounded time and memory.

The subprocess runs `python -m rlbench_pin.builder.custom_assets.conversion`. Its standard input is the job as one line of JSON,
then the file. Its standard output is lines of JSON: `{"note": ...}`, at the end `{"error": ...}` or
`{"urdf": ..., "files": [[name, size], ...]}` followed by the content of the files.
"""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import IO, Any

from rlbench_pin.builder.custom_assets.folder import MESHES, archive_meshes, folder_meshes
from rlbench_pin.builder.custom_assets.mesh_asset import CustomAsset, mesh_asset
from rlbench_pin.builder.custom_assets.uploads import UploadRefused, read_archive, read_mesh
from rlbench_pin.builder.custom_assets.urdf_asset import OnNote, urdf_asset
from rlbench_pin.errors import RlbenchPinError

LONGEST = 180.0
"""Time limit of a conversion [s]."""
MEMORY = 6 * 2**30
"""Address space of the subprocess [bytes]."""


@dataclass(frozen=True)
class Job:
    """What to make of a file."""

    name: str
    """Name of the file in the browser."""
    folder: str
    """Folder of the task, in which meshes are looked up."""
    scale: float
    """Factor on all lengths."""
    mass: float
    """[kg]; 0 keeps the masses of a URDF file."""
    color: tuple[float, ...]
    """Red, green, blue of a mesh, from 0 to 1."""


def convert(job: Job, data: bytes, note: OnNote) -> CustomAsset:
    """Return the asset of a mesh, a URDF file, or an archive with one URDF file and its meshes.

    Args:
        job: What to make of it.
        data: Content of the file.
        note: Called with each step of the work.

    Raises:
        UploadRefused: The file cannot be used.
        InvalidValue: Scale or mass are not above 0.
    """
    name, mass = job.name, job.mass if job.mass != 0.0 else None
    ending = f".{name.rpartition('.')[2].lower()}"
    if ending == ".urdf":
        return urdf_asset(name, data, folder_meshes(Path(job.folder)), job.scale, mass, note)
    if ending == ".zip":
        files = read_archive(name, data, (".urdf", *MESHES))
        urdfs = sorted(path for path in files if path.lower().endswith(".urdf"))
        if len(urdfs) != 1:
            there = f"it has {len(urdfs)} URDF files: {', '.join(urdfs[:8])}" if urdfs else "it has no URDF file"
            raise UploadRefused(name, there, "Send an archive with one of them, and the meshes that it names.")
        return urdf_asset(urdfs[0], files[urdfs[0]], archive_meshes(files, urdfs[0]), job.scale, mass, note)
    if ending not in MESHES:
        raise UploadRefused(name, f"files are .obj, .stl, .urdf and .zip, not '{ending[:20]}'")
    mesh = read_mesh(name, data)
    note(f"Decomposing '{name}' into convex parts: {len(mesh.mesh.faces)} triangles")
    return mesh_asset(mesh, job.scale, job.mass, job.color)


class Conversion:
    """A running conversion.

    Args:
        job: What to make of the file.
        data: Content of the file.
        on_note: Called with the present step and its duration, every second.
        on_end: Called once, with the asset or the error. Both are called in a thread of their own.
        longest: Time limit [s].
    """

    def __init__(
        self,
        job: Job,
        data: bytes,
        on_note: Callable[[str], None],
        on_end: Callable[[CustomAsset | RlbenchPinError], None],
        longest: float = LONGEST,
    ) -> None:
        self._job, self._on_note, self._on_end, self._longest = job, on_note, on_end, longest
        self._ended, self._step, self._over = "", f"Reading '{job.name}'", threading.Event()
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115  # closed when the process has ended
        self._process = subprocess.Popen(
            [sys.executable, "-m", "rlbench_pin.builder.custom_assets.conversion"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._errors, start_new_session=True,
        )  # fmt: skip
        threading.Thread(target=self._run, args=(data,), name="conversion", daemon=True).start()
        threading.Thread(target=self._watch, name="conversion clock", daemon=True).start()

    @property
    def name(self) -> str:
        """Name of the file."""
        return self._job.name

    @property
    def process_id(self) -> int:
        """Process id of the subprocess."""
        return self._process.pid

    def stop(self) -> None:
        """End the conversion."""
        self._end("it was stopped")

    def _end(self, why: str) -> None:
        self._ended = self._ended or why
        self._process.kill()

    def _watch(self) -> None:
        """Report the duration every second; end the subprocess at the time limit."""
        start = time.monotonic()
        while (left := start + self._longest - time.monotonic()) > 0.0:
            if self._over.wait(min(1.0, left)):
                return
            self._on_note(f"{self._step}: {time.monotonic() - start:.0f} s of at most {self._longest:g} s")
        self._end(f"it takes longer than {self._longest:g} s")

    def _run(self, data: bytes) -> None:
        try:
            found: CustomAsset | RlbenchPinError = self._exchange(data)
        except RlbenchPinError as error:
            found = error
        except (OSError, ValueError, KeyError) as error:
            found = self._failure(error)
        finally:
            self._over.set()
            self._process.kill()
            self._process.wait()
            self._errors.close()
        self._on_end(found)

    def _exchange(self, data: bytes) -> CustomAsset:
        """Send the file, and return the answer."""
        stdin, stdout = self._process.stdin, self._process.stdout
        assert stdin is not None
        assert stdout is not None
        with stdin:
            stdin.write(json.dumps(asdict(self._job)).encode() + b"\n")
            stdin.write(data)
        with stdout:
            while "note" in (answer := json.loads(stdout.readline())):
                self._step = str(answer["note"])
                self._on_note(self._step)
            if "error" in answer:
                raise RlbenchPinError(str(answer["error"]))
            return CustomAsset(str(answer["urdf"]), {str(name): _exactly(stdout, int(size)) for name, size in answer["files"]})

    def _failure(self, error: Exception) -> UploadRefused:
        """Return why the subprocess ended without an answer."""
        code = self._process.wait()
        if self._ended:
            hint = "Reduce it first: fewer triangles, fewer parts." if "longer" in self._ended else ""
            return UploadRefused(self.name, self._ended, hint)
        self._errors.seek(0)
        last = self._errors.read().decode(errors="replace").strip().rpartition("\n")[2][:200]
        cause = signal.Signals(-code).name if code < 0 else last or f"exit {code}, {error}"
        return UploadRefused(self.name, f"the process that read it ended ({cause})")


def _exactly(stream: IO[bytes], size: int) -> bytes:
    content = stream.read(size)
    if len(content) != size:
        raise ValueError("the answer is too short")
    return content


# In the subprocess ---------------------------------------------------------------------------------------------------


def _end_with(owner: int) -> None:
    """End this process when its parent has ended."""
    while os.getppid() == owner:
        time.sleep(0.5)
    os._exit(1)


def main() -> None:
    """Convert one file."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    threading.Thread(target=_end_with, args=(os.getppid(),), daemon=True).start()
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # libraries print to standard error

    def say(message: dict[str, Any]) -> None:
        answers.write(json.dumps(message).encode() + b"\n")
        answers.flush()

    words = json.loads(sys.stdin.buffer.readline())
    job = Job(**{**words, "color": tuple(words["color"])})
    try:
        asset = convert(job, sys.stdin.buffer.read(), lambda text: say({"note": text}))
    except RlbenchPinError as error:
        say({"error": str(error)})
    except (MemoryError, RecursionError) as error:
        say({"error": f"'{job.name}' is refused: reading it takes too much memory ({type(error).__name__})."})
    else:
        say({"urdf": asset.urdf, "files": [[name, len(content)] for name, content in asset.files.items()]})
        for content in asset.files.values():
            answers.write(content)
        answers.flush()


if __name__ == "__main__":
    main()
