"""The pictures of one camera of a LeRobotDataset: MP4 files that hold many episodes, one after the other."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from rlbench_pin.datasets.formats.common import FPS
from rlbench_pin.datasets.video import VideoWriter

KEY_FRAMES = 2
"""Every so many frames can be read without those before it."""
QUALITY = 18
"""Constant rate factor of H.264; lower is better, 18 looks like the original."""


class VideoFiles:
    """Appends episodes to the running file, and begins another when it is full.

    Args:
        folder: Folder of the dataset.
        key: Feature.
        shape: Height, width and 3.
        megabytes: Size at which another file is begun.
        chunk_size: Files to a folder.
    """

    def __init__(self, folder: Path, key: str, shape: tuple[int, int, int], megabytes: int, chunk_size: int) -> None:
        self._folder, self._key, self._shape = folder, key, shape
        self._limit, self._chunk_size = megabytes * 2**20, chunk_size
        self._writer: VideoWriter | None = None
        self._number = -1
        self.codec = ""

    def add(self, pictures: Sequence[np.ndarray]) -> dict[str, int | float]:
        """Append the pictures of one episode and return where they are."""
        if self._writer is None or self._writer.bytes_written > self._limit:
            self._next_file()
        assert self._writer is not None
        first = self._writer.frames
        for picture in pictures:
            self._writer.add(picture)
        place = {
            "chunk_index": self._number // self._chunk_size,
            "file_index": self._number % self._chunk_size,
            "from_timestamp": first / FPS,
            "to_timestamp": (first + len(pictures)) / FPS,
        }
        return {f"videos/{self._key}/{name}": value for name, value in place.items()}

    def close(self) -> None:
        """Finish the present file."""
        if self._writer is not None:
            self._writer.close()
        self._writer = None

    def discard(self) -> None:
        """Throw the present file away."""
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
