"""What a dataset holds, from its manifests and the head of one file: no episode is read."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rlbench_pin.datasets.episode import Episode
from rlbench_pin.datasets.layout import manifest_path
from rlbench_pin.datasets.manifest import EpisodeEntry, read_manifest
from rlbench_pin.errors import DatasetError
from rlbench_pin.observation import CAMERAS, PRODUCTS


@dataclass(frozen=True)
class TaskInfo:
    """The stored episodes of one task."""

    task: str
    episodes: int
    variations: tuple[int, ...]
    frames: int
    shortest: int
    """Frames of the shortest episode."""
    median: float
    """Median number of frames."""
    longest: int
    num_bytes: int
    retried: int
    """Episodes that needed more than one try."""
    causes: dict[str, int]
    """Kind of failure -> tries that failed so."""
    pictures: dict[str, tuple[int, ...]]
    """Picture field -> its shape, in the first episode."""
    versions: dict[str, tuple[str, ...]]
    """Library -> its versions."""


def task_info(root: Path, task: str) -> TaskInfo:
    """Sum up the stored episodes of a task.

    Raises:
        DatasetError: The manifest is missing, or it or the first file cannot be read.
    """
    entries = read_manifest(root, task)
    if not entries:
        raise DatasetError(f"'{manifest_path(root, task)}' lists no episodes. Record some with `rlbench-pin record {task}`.")
    frames = [e.frames for e in entries]
    return TaskInfo(
        task=task,
        episodes=len(entries),
        variations=tuple(sorted({e.variation for e in entries})),
        frames=sum(frames),
        shortest=min(frames),
        median=float(np.median(frames)),
        longest=max(frames),
        num_bytes=sum(e.num_bytes for e in entries),
        retried=sum(bool(e.failures) or e.attempt > 0 for e in entries),
        causes=dict(Counter(f.split(":")[0] for e in entries for f in e.failures)),
        pictures=stored_pictures(manifest_path(root, task).parent / entries[0].file),
        versions=_versions(entries),
    )


def stored_pictures(path: Path) -> dict[str, tuple[int, ...]]:
    """Return the picture fields of an episode file and their shapes."""
    with Episode(path) as episode:
        wanted = [f"{camera}_{product}" for camera in CAMERAS for product in PRODUCTS]
        return {name: episode.shape(name) for name in wanted if name in episode.fields}


def _versions(entries: tuple[EpisodeEntry, ...]) -> dict[str, tuple[str, ...]]:
    names = sorted({name for e in entries for name in e.versions})
    return {name: tuple(sorted({e.versions[name] for e in entries if name in e.versions})) for name in names}
