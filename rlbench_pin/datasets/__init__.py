"""Demonstrations on disk: one HDF5 file per episode, a manifest per task, videos."""

from __future__ import annotations

from rlbench_pin.datasets.episode import Episode
from rlbench_pin.datasets.frames import FrameDataset
from rlbench_pin.datasets.key_frames import key_frame_actions, key_frames
from rlbench_pin.datasets.layout import (
    EPISODE_SUFFIX,
    checked_task_name,
    chosen_tasks,
    episode_files,
    episode_path,
    stored_tasks,
    stored_variations,
)
from rlbench_pin.datasets.manifest import EpisodeEntry, fold_journal, has_manifest, read_manifest
from rlbench_pin.datasets.merge import Move, merge_datasets, plan_merge
from rlbench_pin.datasets.reader import (
    TaskInfo,
    check_there,
    counted_demo,
    counted_files,
    read_demo,
    read_image,
    stored_demos,
    stored_images,
    task_info,
)
from rlbench_pin.datasets.storage import hold, remove_leftovers, write_whole
from rlbench_pin.datasets.task_copy import KeptTask, keep_files, kept_task
from rlbench_pin.datasets.trust import Inspector
from rlbench_pin.datasets.verify import task_faults, verify_task
from rlbench_pin.datasets.video import VideoWriter
from rlbench_pin.datasets.writer import Compression, DatasetWriter, encode_demo, episode_entry, write_demo

__all__ = [
    "EPISODE_SUFFIX",
    "Compression",
    "DatasetWriter",
    "Episode",
    "EpisodeEntry",
    "FrameDataset",
    "Inspector",
    "KeptTask",
    "Move",
    "TaskInfo",
    "VideoWriter",
    "check_there",
    "checked_task_name",
    "chosen_tasks",
    "counted_demo",
    "counted_files",
    "encode_demo",
    "episode_entry",
    "episode_files",
    "episode_path",
    "fold_journal",
    "has_manifest",
    "hold",
    "keep_files",
    "kept_task",
    "key_frame_actions",
    "key_frames",
    "merge_datasets",
    "plan_merge",
    "read_demo",
    "read_image",
    "read_manifest",
    "remove_leftovers",
    "stored_demos",
    "stored_images",
    "stored_tasks",
    "stored_variations",
    "task_faults",
    "task_info",
    "verify_task",
    "write_demo",
    "write_whole",
]
