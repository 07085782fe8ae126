"""Export to a LeRobotDataset, version 3.0: frames in Parquet, images in MP4, many episodes to a file.

Frame t has the state of frame t and the command that leads to frame t + 1; the last frame repeats the last command.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from rlbench_pin.datasets.episode import Episode
from rlbench_pin.datasets.formats.common import (
    FPS,
    OnEpisode,
    StoredEpisode,
    actions,
    column_statistics,
    joint_names,
    joint_state,
    new_folder,
    opened,
    rgb_cameras,
    stored_episodes,
)
from rlbench_pin.datasets.video import VideoWriter

KEY_FRAMES = 2
"""Every so many frames can be read without those before it."""
QUALITY = 18
"""Constant rate factor of H.264; lower is better, 18 is visually lossless."""
VERSION = "v3.0"
CHUNK_SIZE, DATA_MEGABYTES, VIDEO_MEGABYTES = 1000, 100, 200
_DATA = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
_VIDEO = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"
_EPISODES = "meta/episodes/chunk-000/file-000.parquet"
_IMAGES_FOR_STATISTICS = 100
Column = list[Any] | np.ndarray


class VideoFiles:
    """Appends episodes to the present file, and begins another when it is full.

    Args:
        folder: Folder of the dataset.
        key: Feature.
        shape: Height, width and 3.
        megabytes: Size at which another file is begun [MB].
        chunk_size: Number of files in a folder.
    """

    def __init__(self, folder: Path, key: str, shape: tuple[int, int, int], megabytes: int, chunk_size: int) -> None:
        self._folder, self._key, self._shape = folder, key, shape
        self._limit, self._chunk_size = megabytes * 2**20, chunk_size
        self._writer: VideoWriter | None = None
        self._number = -1
        self.codec = ""

    def add(self, images: Sequence[np.ndarray]) -> dict[str, int | float]:
        if self._writer is None or self._writer.bytes_written > self._limit:
            self._next_file()
        assert self._writer is not None
        first = self._writer.frames
        for image in images:
            self._writer.add(image)
        place = {
            "chunk_index": self._number // self._chunk_size,
            "file_index": self._number % self._chunk_size,
            "from_timestamp": first / FPS,
            "to_timestamp": (first + len(images)) / FPS,
        }
        return {f"videos/{self._key}/{name}": value for name, value in place.items()}

    def close(self) -> None:
        if self._writer is not None:
            self._writer.close()
        self._writer = None

    def discard(self) -> None:
        if self._writer is not None:
            self._writer.discard()
        self._writer = None

    def info(self) -> dict[str, object]:
        """Return the description of the encoding that readers need."""
        height, width, _ = self._shape
        return {
            "video.height": height,
            "video.width": width,
            "video.codec": self.codec,
            "video.pix_fmt": "yuv420p",
            "video.is_depth_map": False,
            "video.fps": FPS,
            "video.channels": 3,
            "has_audio": False,
        }

    def _next_file(self) -> None:
        self.close()
        self._number += 1
        chunk, file = divmod(self._number, self._chunk_size)
        path = self._folder / "videos" / self._key / f"chunk-{chunk:03d}" / f"file-{file:03d}.mp4"
        height, width, _ = self._shape
        self._writer = VideoWriter(path, (width, height), FPS, key_frames=KEY_FRAMES, quality=QUALITY)
        self.codec = self._writer.codec


def export_lerobot(
    root: Path,
    out: Path,
    *,
    tasks: Sequence[str] = (),
    cameras: Sequence[str] = (),
    on_episode: OnEpisode | None = None,
) -> Path:
    """Write the episodes of a dataset as a LeRobotDataset.

    Args:
        root: Folder of the dataset.
        out: The new folder; `LeRobotDataset(repo_id, root=out)` loads it.
        tasks: Only these tasks; all if empty.
        cameras: Cameras whose images are exported; all stored ones if empty.
        on_episode: Called after each episode.

    Raises:
        DatasetError: Something is missing or damaged, or images cannot be encoded.
    """
    episodes = stored_episodes(root, tasks)
    shapes = rgb_cameras(episodes, cameras)
    with new_folder(out) as folder:
        export = _Export(folder, {f"observation.images.{name}": shape for name, shape in shapes.items()})
        try:
            for stored, episode in opened(episodes, on_episode):
                export.add(stored, episode)
            export.finish()
        except BaseException:
            export.discard()
            raise
    return out


@dataclass
class _Export:
    """State of an export: the open files, and the counts so far."""

    folder: Path
    images: dict[str, tuple[int, int, int]]
    """Feature -> shape of its images."""
    instructions: dict[str, int] = field(default_factory=dict)
    """Sentence -> number."""
    rows: list[dict[str, Any]] = field(default_factory=list)
    """One row per episode."""
    samples: dict[str, list[np.ndarray]] = field(default_factory=dict)
    """Feature -> values of each episode, for the statistics of all."""
    frames: int = 0
    robot: str = ""
    """Name of the arm."""
    joints: list[str] = field(default_factory=list)
    """Names of the numbers of a state and of an action."""

    def __post_init__(self) -> None:
        self._data = _DataFiles(self.folder)
        self._videos = {
            key: VideoFiles(self.folder, key, shape, VIDEO_MEGABYTES, CHUNK_SIZE) for key, shape in self.images.items()
        }

    def add(self, stored: StoredEpisode, episode: Episode) -> None:
        text = episode.instructions[0] if episode.instructions else stored.task.replace("_", " ")
        task = self.instructions.setdefault(text, len(self.instructions))
        columns = self._columns(episode, task)
        self.robot, self.joints = episode.robot, joint_names(episode)
        row: dict[str, Any] = {
            "episode_index": len(self.rows),
            "tasks": [text],
            "length": len(episode),
            **self._data.add(columns),
            "dataset_from_index": self.frames,
            "dataset_to_index": self.frames + len(episode),
            "meta/episodes/chunk_index": 0,
            "meta/episodes/file_index": 0,
        }
        statistics = {name: column_statistics(np.asarray(values)) for name, values in columns.items()}
        for key, videos in self._videos.items():
            images = episode.series(key.removeprefix("observation.images.") + "_rgb")
            row.update(videos.add(images))
            sample = _channels(images)
            self.samples.setdefault(key, []).append(sample)
            statistics[key] = _per_channel(sample, len(images))
        for name, values in columns.items():
            self.samples.setdefault(name, []).append(np.asarray(values))
        row.update({f"stats/{name}/{kind}": value for name, kinds in statistics.items() for kind, value in kinds.items()})
        self.rows.append(row)
        self.frames += len(episode)

    def _columns(self, episode: Episode, task: int) -> dict[str, np.ndarray]:
        count = len(episode)
        commands = actions(episode)
        last = np.arange(count) == count - 1
        return {
            "observation.state": joint_state(episode).astype(np.float32),
            "action": np.concatenate([commands, commands[-1:]]).astype(np.float32),
            "next.reward": last.astype(np.float32),
            "next.done": last,
            "timestamp": (np.arange(count) / FPS).astype(np.float32),
            "frame_index": np.arange(count),
            "episode_index": np.full(count, len(self.rows)),
            "index": self.frames + np.arange(count),
            "task_index": np.full(count, task),
        }

    def finish(self) -> None:
        """Write the metadata of the dataset."""
        self.close()
        table = pa.Table.from_pylist(self.rows)
        path = self.folder / _EPISODES
        path.parent.mkdir(parents=True)
        _write_table(table, path)
        _write_tasks(self.folder / "meta" / "tasks.parquet", self.instructions)
        _write_json(self.folder / "meta" / "stats.json", self._statistics())
        _write_json(self.folder / "meta" / "info.json", self._info())

    def close(self) -> None:
        self._data.close()
        for videos in self._videos.values():
            videos.close()

    def discard(self) -> None:
        """Close all files and ignore their errors: the disk may be full."""
        with suppress(OSError):
            self._data.close()
        for videos in self._videos.values():
            videos.discard()

    def _statistics(self) -> dict[str, Any]:
        whole = {name: np.concatenate(values) for name, values in self.samples.items()}
        return {
            name: _per_channel(values, self.frames) if name in self.images else column_statistics(values)
            for name, values in whole.items()
        }

    def _info(self) -> dict[str, Any]:
        return {
            "codebase_version": VERSION,
            "robot_type": self.robot,
            "total_episodes": len(self.rows),
            "total_frames": self.frames,
            "total_tasks": len(self.instructions),
            "chunks_size": CHUNK_SIZE,
            "data_files_size_in_mb": DATA_MEGABYTES,
            "video_files_size_in_mb": VIDEO_MEGABYTES,
            "fps": FPS,
            "splits": {"train": f"0:{len(self.rows)}"},
            "data_path": _DATA,
            "video_path": _VIDEO if self.images else None,
            "features": self._features(),
        }

    def _features(self) -> dict[str, Any]:
        joints = {"dtype": "float32", "shape": [len(self.joints)], "names": self.joints}
        scalars = {
            "next.reward": "float32", "next.done": "bool", "timestamp": "float32", "frame_index": "int64",
            "episode_index": "int64", "index": "int64", "task_index": "int64",
        }  # fmt: skip
        images = {
            key: {
                "dtype": "video",
                "shape": list(shape),
                "names": ["height", "width", "channels"],
                "info": self._videos[key].info(),
            }
            for key, shape in self.images.items()
        }
        return {
            "observation.state": joints,
            "action": joints,
            **images,
            **{name: {"dtype": dtype, "shape": [1], "names": None} for name, dtype in scalars.items()},
        }


class _DataFiles:
    """Writes frames to Parquet files of limited size."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._bytes, self._number = folder, 0, -1
        self._writer: Any = None

    def add(self, columns: dict[str, np.ndarray]) -> dict[str, int]:
        table = pa.table({name: _arrow(values) for name, values in columns.items()})
        if self._writer is None or self._bytes + table.nbytes > DATA_MEGABYTES * 2**20:
            self.close()
            self._number, self._bytes = self._number + 1, 0
            path = self._folder / _DATA.format(**self._place())
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = open(path, "wb")  # noqa: SIM115
            self._writer = pq.ParquetWriter(self._file, table.schema, compression="snappy")
        self._writer.write_table(table)
        self._bytes += table.nbytes
        return {f"data/{name}": value for name, value in self._place().items()}

    def close(self) -> None:
        if self._writer is not None:
            writer, self._writer = self._writer, None
            with self._file:  # on a full disk the writer would leave it open
                writer.close()

    def _place(self) -> dict[str, int]:
        return {"chunk_index": self._number // CHUNK_SIZE, "file_index": self._number % CHUNK_SIZE}


def _arrow(values: np.ndarray) -> pa.Array:
    if values.ndim == 1:
        return pa.array(values)
    return pa.FixedSizeListArray.from_arrays(pa.array(values.reshape(-1)), values.shape[1])


def _channels(images: Sequence[np.ndarray]) -> np.ndarray:
    """Return colours (n, 3) in 0..1 of evenly spaced pixels of evenly spaced images."""
    every = max(1, len(images) // _IMAGES_FOR_STATISTICS)
    return np.concatenate([image[::4, ::4].reshape(-1, 3) for image in images[::every]]).astype(np.float32) / 255.0


def _per_channel(colours: np.ndarray, images: int) -> dict[str, Any]:
    shaped = {kind: [[[v]] for v in value] for kind, value in column_statistics(colours).items() if kind != "count"}
    return {**shaped, "count": [images]}


def _write_tasks(path: Path, instructions: dict[str, int]) -> None:
    """Write sentence -> number with the sentences as the pandas index."""
    name = "__index_level_0__"
    table = pa.table({"task_index": pa.array(list(instructions.values()), pa.int64()), name: pa.array(list(instructions))})
    columns = [
        {"name": "task_index", "field_name": "task_index", "pandas_type": "int64", "numpy_type": "int64", "metadata": None},
        {"name": None, "field_name": name, "pandas_type": "unicode", "numpy_type": "object", "metadata": None},
    ]
    pandas = {"index_columns": [name], "column_indexes": [], "columns": columns, "pandas_version": "2.0.0"}
    _write_table(table.replace_schema_metadata({"pandas": json.dumps(pandas)}), path)


def _write_table(table: pa.Table, path: Path) -> None:
    with open(path, "wb") as file:  # on a full disk pyarrow would leave it open
        pq.write_table(table, file, compression="snappy")


def _write_json(path: Path, content: dict[str, Any]) -> None:
    path.write_text(json.dumps(content, indent=4) + "\n", encoding="utf-8")
