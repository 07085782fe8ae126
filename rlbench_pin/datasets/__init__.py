"""Demonstrations on disk: one HDF5 file per episode, a manifest per task, films of what happened."""

from __future__ import annotations

from rlbench_pin.datasets.layout import EPISODE_SUFFIX, episode_files, episode_path, stored_variations
from rlbench_pin.datasets.manifest import EpisodeEntry, read_manifest, verify_task
from rlbench_pin.datasets.reader import read_demo, stored_demos
from rlbench_pin.datasets.video import VideoWriter
from rlbench_pin.datasets.writer import DatasetWriter, write_demo

__all__ = [
    "EPISODE_SUFFIX",
    "DatasetWriter",
    "EpisodeEntry",
    "VideoWriter",
    "episode_files",
    "episode_path",
    "read_demo",
    "read_manifest",
    "stored_demos",
    "stored_variations",
    "verify_task",
    "write_demo",
]
