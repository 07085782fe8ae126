"""Videos: writes images to an MP4 file that players and browsers can open."""

from __future__ import annotations

import os
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import cast

import av
import numpy as np

from rlbench_pin.errors import DatasetError, storing
from rlbench_pin.values import as_image_size, as_path, as_whole

_CODECS: tuple[tuple[str, dict[str, str]], ...] = (
    ("libx264", {"preset": "medium"}),
    ("mpeg4", {"qscale": "3"}),
)


class VideoWriter:
    """Writer of an MP4 file, which is created when the writer is closed without an error.

    Args:
        path: The file; an existing one is replaced.
        size: Width and height [px], both even.
        fps: Images per second [1/s].
        key_frames: Interval of the key frames of the video, in images; None is the default of the encoder.
        quality: Constant rate factor of H.264, lower is better.
    """

    def __init__(
        self, path: Path, size: tuple[int, int], fps: int = 20, *, key_frames: int | None = None, quality: int = 20
    ) -> None:
        size = as_image_size(size, "size of a video")
        fps, quality = as_whole(fps, "fps", least=1, most=1000), as_whole(quality, "quality", least=0, most=51)
        if key_frames is not None:
            key_frames = as_whole(key_frames, "key_frames", least=1, most=100_000)
        if size[0] % 2 or size[1] % 2:
            raise DatasetError(f"A video of {size[0]} x {size[1]} px cannot be encoded; choose an even width and height.")
        self.path, self.size, self.frames = as_path(path, "path"), size, 0
        if not self.path.name:
            raise DatasetError(f"'{path}' is not a name of a video. Name a file, such as 'out/video.mp4'.")
        with storing(self.path):
            self.path.parent.mkdir(parents=True, exist_ok=True)
        self._temporary = self.path.with_name(f".{self.path.stem}.{os.getpid()}.part.mp4")
        # `file:` because FFmpeg takes what stands before a colon in a path for a protocol.
        self._container = av.open(f"file:{self._temporary}", mode="w", options={"movflags": "faststart"})
        codec, options = _available_codec()
        options = options | ({"crf": str(quality)} if codec == "libx264" else {})
        options |= {} if key_frames is None else {"g": str(key_frames)}
        self.bytes_written = 0
        """Size of the encoded images so far."""
        self._stream = cast(av.VideoStream, self._container.add_stream(codec, rate=fps, options=options))
        self.codec = str(self._stream.codec.canonical_name)
        """Name of the encoding."""
        self._stream.width, self._stream.height = size
        self._stream.pix_fmt = "yuv420p"
        self._stream.codec_context.time_base = Fraction(1, fps)
        self._stream.codec_context.thread_count = 1

    def add(self, image: np.ndarray) -> None:
        """Append one image, uint8 (h, w, 3)."""
        width, height = self.size
        shape = getattr(image, "shape", None)
        if shape != (height, width, 3) or image.dtype.kind not in "ui":
            kind = getattr(image, "dtype", type(image).__name__)
            raise DatasetError(f"An image of shape {shape} and type {kind} does not fit a video of {width} x {height} px.")
        frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(image, dtype=np.uint8), format="rgb24")
        frame.pts = self.frames
        self.frames += 1
        for packet in self._stream.encode(frame):
            self._mux(packet)

    def _mux(self, packet: av.Packet) -> None:
        self.bytes_written += packet.size
        self._container.mux(packet)

    def close(self) -> Path:
        """Finish the file and return its path."""
        if self.frames == 0:
            self.discard()
            raise DatasetError(f"The video '{self.path}' has no images. Add at least one.")
        try:
            for packet in self._stream.encode(None):
                self._mux(packet)
            self._container.close()
            os.replace(self._temporary, self.path)
        except Exception:
            self.discard()
            raise
        return self.path

    def discard(self) -> None:
        """Delete the unfinished file."""
        for _ in range(2):  # on a full disk the first may end with what is still to be written, before the file is closed
            with suppress(OSError, av.error.FFmpegError):
                self._container.close()
        self._temporary.unlink(missing_ok=True)

    def __enter__(self) -> VideoWriter:
        return self

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None) -> None:
        if kind is None:
            self.close()
        else:
            self.discard()


def _available_codec() -> tuple[str, dict[str, str]]:
    """Return the first encoder that FFmpeg supports here, with its options."""
    for name, options in _CODECS:
        if name in av.codecs_available:
            return name, options
    raise DatasetError("This build of PyAV has neither an H.264 nor an MPEG-4 encoder. Install the wheel of `av`.")
