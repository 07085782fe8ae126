"""The door of the builder: a page on this machine behind a token, a folder that nobody leaves, files that are checked."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.builder.server.archives import read_archive
from rlbench_pin.builder.server.errors import OutsideFolder, ServerError, UploadRefused
from rlbench_pin.builder.server.folder import Folder
from rlbench_pin.builder.server.local_server import LocalServer
from rlbench_pin.builder.server.uploads import LARGEST_UPLOAD, UploadedMesh, read_mesh, upload_stem
from rlbench_pin.front_door import front_door

__all__ = [
    "LARGEST_UPLOAD",
    "Folder",
    "LocalServer",
    "OutsideFolder",
    "ServerError",
    "UploadRefused",
    "UploadedMesh",
    "read_archive",
    "read_mesh",
    "upload_stem",
]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
