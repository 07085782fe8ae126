"""Conversion of an uploaded file to an asset, in a subprocess with limited time and memory.

The owner sends `{"job": ..., "data": ...}`. The subprocess answers with `{"note": ...}` for each step, at the end with
`{"error": ...}` or `{"urdf": ..., "files": ...}`.
"""

from __future__ import annotations

import select
import threading
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

from rlbench_pin.builder.custom_assets.folder import MESHES, archive_meshes, folder_meshes
from rlbench_pin.builder.custom_assets.mesh_asset import CustomAsset, mesh_asset
from rlbench_pin.builder.custom_assets.uploads import UploadRefused, read_archive, read_mesh
from rlbench_pin.builder.custom_assets.urdf_asset import OnNote, urdf_asset
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.evaluation.policies.policy_server import Channel, WireError
from rlbench_pin.processes.child import ChildProcess, connect_to_owner, limit_memory

TIME_LIMIT = 180.0
"""Time limit of a conversion [s]."""
MEMORY = 6 * 2**30
"""Address space of the subprocess in addition to its libraries [bytes]."""


@dataclass(frozen=True)
class Job:
    """An uploaded file, and the asset to make of it."""

    name: str
    """Name of the file in the browser."""
    folder: str
    """Folder of the task, which is searched for meshes."""
    scale: float
    """Factor on all lengths."""
    mass: float
    """[kg]; 0 keeps the masses of a URDF file."""
    color: tuple[float, ...]
    """Red, green, blue of a mesh, from 0 to 1."""


def convert(job: Job, data: bytes, note: OnNote) -> CustomAsset:
    """Return the asset of a mesh, a URDF file, or an archive with one URDF file and its meshes.

    Args:
        job: The file, and the asset to make of it.
        data: Content of the file.
        note: Called with each step of the work.

    Raises:
        UploadRefused: The file cannot be used.
        InvalidValue: Scale or mass is not above 0.
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
        raise UploadRefused(name, f"its ending is '{ending[:20]}'", "Send an .obj, .stl, .urdf or .zip file.")
    mesh = read_mesh(name, data)
    note(f"Decomposing '{name}' into convex parts: {len(mesh.mesh.faces)} triangles")
    return mesh_asset(mesh, job.scale, job.mass, job.color)


class Conversion:
    """A running conversion.

    Args:
        job: The file, and the asset to make of it.
        data: Content of the file.
        on_note: Called with the current step and its duration, every second.
        on_end: Called once, with the asset or the error. Both are called in the thread of the conversion.
        time_limit: Time limit [s].
    """

    def __init__(
        self,
        job: Job,
        data: bytes,
        on_note: Callable[[str], None],
        on_end: Callable[[CustomAsset | RlbenchPinError], None],
        time_limit: float = TIME_LIMIT,
    ) -> None:
        self._job, self._on_note, self._on_end, self._time_limit = job, on_note, on_end, time_limit
        self._ended = ""
        self._child = ChildProcess("rlbench_pin.builder.custom_assets.conversion")
        threading.Thread(target=self._run, args=(data,), name="conversion", daemon=True).start()

    @property
    def name(self) -> str:
        """Name of the file."""
        return self._job.name

    def stop(self) -> None:
        """End the conversion."""
        self._end("it was stopped")

    def _end(self, why: str) -> None:
        self._ended = self._ended or why
        self._child.end()

    def _run(self, data: bytes) -> None:
        channel = Channel(self._child.connection)
        try:
            found: CustomAsset | RlbenchPinError = self._request(channel, data)
        except RlbenchPinError as error:
            found = error
        except TimeoutError:
            self._end(f"it takes longer than {self._time_limit:g} s")
            found = self._failure()
        except (EOFError, OSError, WireError, KeyError):
            found = self._failure()
        finally:
            self._child.end()
            channel.close()
        self._on_end(found)

    def _request(self, channel: Channel, data: bytes) -> CustomAsset:
        """Send the file, report the duration every second, and return the answer; end the subprocess at the time limit."""
        start, step = time.monotonic(), f"Reading '{self.name}'"
        channel.send({"job": asdict(self._job), "data": data}, self._time_limit)
        while (left := start + self._time_limit - time.monotonic()) > 0.0:
            if not select.select([self._child.connection], [], [], min(1.0, left))[0]:
                self._on_note(f"{step}: {time.monotonic() - start:.0f} s of at most {self._time_limit:g} s")
                continue
            answer = channel.receive(left)
            if "error" in answer:
                raise RlbenchPinError(str(answer["error"]))
            if "urdf" in answer:
                return CustomAsset(str(answer["urdf"]), {str(name): bytes(content) for name, content in answer["files"].items()})
            step = str(answer["note"])
            self._on_note(step)
        raise TimeoutError

    def _failure(self) -> UploadRefused:
        """Return why the subprocess ended without an answer."""
        how = self._child.end(patience=2.0)
        if self._ended:
            hint = "Reduce it first: fewer triangles, fewer parts." if "longer" in self._ended else ""
            return UploadRefused(self.name, self._ended, hint)
        printed = self._child.printed().rpartition("\n")[2][:200]
        return UploadRefused(self.name, f"the process that read it ended: {how} {printed}".strip())


# In the subprocess ---------------------------------------------------------------------------------------------------


def main() -> None:
    """Convert one file."""
    connection, _ = connect_to_owner()
    limit_memory(MEMORY)
    channel = Channel(connection)
    question = channel.receive()
    job = Job(**{**question["job"], "color": tuple(question["job"]["color"])})
    try:
        asset = convert(job, question["data"], lambda text: channel.send({"note": text}))
    except RlbenchPinError as error:
        channel.send({"error": str(error)})
    except (MemoryError, RecursionError) as error:
        channel.send({"error": f"'{job.name}' is refused: reading it takes too much memory ({type(error).__name__})."})
    else:
        channel.send({"urdf": asset.urdf, "files": dict(asset.files)})


if __name__ == "__main__":
    main()
