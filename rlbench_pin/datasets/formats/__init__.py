"""Formats of other libraries: one exporter per module, and the reader of RLBench-style folders.

`lerobot` and `zarr_buffer` need extras, so they are imported by name; `rlbench_pin.recording.export` does that for every format.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.datasets.formats.common import StoredEpisode, stored_episodes
from rlbench_pin.datasets.formats.rlbench_folders import export_rlbench
from rlbench_pin.datasets.formats.rlbench_reader import folder_demos, folder_descriptions, folder_episodes, read_folder
from rlbench_pin.datasets.formats.robomimic import export_robomimic
from rlbench_pin.front_door import front_door

__all__ = [
    "StoredEpisode",
    "export_rlbench",
    "export_robomimic",
    "folder_demos",
    "folder_descriptions",
    "folder_episodes",
    "read_folder",
    "stored_episodes",
]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
