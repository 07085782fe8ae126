"""Videos hold the images that went in."""

from __future__ import annotations

from pathlib import Path

import av
import numpy as np
import pytest

from rlbench_pin.datasets import VideoWriter
from rlbench_pin.errors import DatasetError


def test_pictures_come_back(tmp_path: Path) -> None:
    """Number, size, rate and rough colours of the images survive the encoding."""
    with VideoWriter(tmp_path / "film.mp4", (64, 48), fps=20) as video:
        for i in range(30):
            video.add(np.full((48, 64, 3), (8 * i, 100, 50), dtype=np.uint8))
    with av.open(str(tmp_path / "film.mp4")) as film:
        stream = film.streams.video[0]
        assert (stream.width, stream.height, float(stream.average_rate)) == (64, 48, 20.0)
        pictures = [frame.to_ndarray(format="rgb24") for frame in film.decode(stream)]
    assert len(pictures) == 30
    assert np.abs(pictures[20].astype(int).mean(axis=(0, 1)) - (160, 100, 50)).max() < 12


def test_an_error_leaves_no_file(tmp_path: Path) -> None:
    """A video that was not finished is not there."""
    with pytest.raises(ZeroDivisionError), VideoWriter(tmp_path / "film.mp4", (64, 48)) as video:
        video.add(np.zeros((48, 64, 3), dtype=np.uint8))
        raise ZeroDivisionError
    assert list(tmp_path.iterdir()) == []


def test_bad_sizes_are_refused(tmp_path: Path) -> None:
    """Odd sizes, wrong images and empty videos are errors."""
    with pytest.raises(DatasetError, match="even width"):
        VideoWriter(tmp_path / "a.mp4", (63, 48))
    with pytest.raises(DatasetError, match="does not fit"), VideoWriter(tmp_path / "b.mp4", (64, 48)) as video:
        video.add(np.zeros((10, 10, 3), dtype=np.uint8))
    with pytest.raises(DatasetError, match="no images"), VideoWriter(tmp_path / "c.mp4", (64, 48)):
        pass
