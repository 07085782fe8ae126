"""Demonstrations on disk: one HDF5 file per episode, a manifest per task, films of what happened."""

from __future__ import annotations

from rlbench_pin.datasets.episode import Episode
from rlbench_pin.datasets.layout import (
    EPISODE_SUFFIX,
    checked_task_name,
    episode_files,
    episode_path,
    stored_tasks,
    stored_variations,
)
from rlbench_pin.datasets.manifest import EpisodeEntry, fold_journal, read_manifest
from rlbench_pin.datasets.reader import read_demo, read_picture, stored_demos
from rlbench_pin.datasets.verify import task_faults, verify_task
from rlbench_pin.datasets.video import VideoWriter
from rlbench_pin.datasets.writer import DatasetWriter, encode_demo, episode_entry, write_demo

__all__ = [
    "EPISODE_SUFFIX",
    "DatasetWriter",
    "Episode",
    "EpisodeEntry",
    "VideoWriter",
    "checked_task_name",
    "encode_demo",
    "episode_entry",
    "episode_files",
    "episode_path",
    "fold_journal",
    "read_demo",
    "read_manifest",
    "read_picture",
    "stored_demos",
    "stored_tasks",
    "stored_variations",
    "task_faults",
    "verify_task",
    "write_demo",
]
