"""What runs in a process apart: `python -m rlbench_pin.builder.view.own.workshop`, a file in, an asset out.

Standard input has an order as one line of JSON, then the file. Standard output has lines of JSON: `{"note": ...}`, and at the
end `{"error": ...}` or `{"urdf": ..., "files": [[name, size], ...]}` with the files behind it.
"""

from __future__ import annotations

import json
import os
import resource
import sys
import threading
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rlbench_pin.builder.server import UploadRefused, read_archive, read_mesh
from rlbench_pin.builder.view.own.meshes import mesh_asset
from rlbench_pin.builder.view.own.model import OnNote, urdf_asset
from rlbench_pin.builder.view.own.solids import OwnAsset
from rlbench_pin.builder.view.own.sources import MESHES, source_of_archive, source_of_folder
from rlbench_pin.errors import RlbenchPinError

MEMORY = 6 * 2**30
"""Address space of the process [bytes]."""


@dataclass(frozen=True)
class Order:
    """What is to be made of a file."""

    name: str
    """Of the file, as it was sent."""
    folder: str
    """Of the task, in which meshes are looked for."""
    scale: float
    """Factor on all lengths."""
    mass: float
    """[kg]; 0 is as a URDF file says."""
    color: tuple[float, ...]
    """Of a mesh: red, green, blue from 0 to 1."""

    def written(self) -> bytes:
        """Return it as a line."""
        return json.dumps(asdict(self)).encode() + b"\n"


def made(order: Order, data: bytes, note: OnNote) -> OwnAsset:
    """Return the asset of a file that was sent: a mesh, a URDF file, or an archive with one URDF file and its meshes.

    Args:
        order: What is to be made.
        data: Content of the file.
        note: Told what is being done.

    Raises:
        UploadRefused: The file is of no use, with the reason.
        InvalidValue: Scale or mass are not above 0.
    """
    name, mass = order.name, order.mass if order.mass != 0.0 else None
    ending = f".{name.rpartition('.')[2].lower()}"
    if ending == ".urdf":
        return urdf_asset(name, data, source_of_folder(Path(order.folder)), order.scale, mass, note)
    if ending == ".zip":
        files = read_archive(name, data, (".urdf", *MESHES))
        urdfs = sorted(path for path in files if path.lower().endswith(".urdf"))
        if len(urdfs) != 1:
            there = f"it has {len(urdfs)} URDF files: {', '.join(urdfs[:8])}" if urdfs else "it has no URDF file"
            raise UploadRefused(name, there, "Send an archive with one of them, and the meshes that it names.")
        return urdf_asset(urdfs[0], files[urdfs[0]], source_of_archive(files, urdfs[0]), order.scale, mass, note)
    if ending not in MESHES:
        raise UploadRefused(name, f"files are .obj, .stl, .urdf and .zip, not '{ending[:20]}'")
    mesh = read_mesh(name, data)
    note(f"Taking '{name}' apart into convex parts: {len(mesh.mesh.faces)} triangles")
    return mesh_asset(mesh, order.scale, order.mass, order.color)


def _limit(most: int) -> None:
    """Bound the memory of this process; no core dumps."""
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _end_with(owner: int) -> None:
    """End this process soon after the one that started it, whatever it is at."""
    while os.getppid() == owner:
        time.sleep(0.5)
    os._exit(1)


def main() -> None:
    """Do one order."""
    _limit(MEMORY)
    threading.Thread(target=_end_with, args=(os.getppid(),), daemon=True).start()
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what libraries print is no answer

    def say(message: dict[str, Any]) -> None:
        answers.write(json.dumps(message).encode() + b"\n")
        answers.flush()

    said = json.loads(sys.stdin.buffer.readline())
    order = Order(**{**said, "color": tuple(said["color"])})
    try:
        asset = made(order, sys.stdin.buffer.read(), lambda text: say({"note": text}))
    except RlbenchPinError as error:
        say({"error": str(error)})
    except (MemoryError, RecursionError) as error:
        say({"error": f"'{order.name}' is not taken: reading it takes too much memory ({type(error).__name__})."})
    else:
        say({"urdf": asset.urdf, "files": [[name, len(content)] for name, content in asset.files.items()]})
        for content in asset.files.values():
            answers.write(content)
        answers.flush()


if __name__ == "__main__":
    main()
