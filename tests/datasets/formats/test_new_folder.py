"""The place that an export is written to: it appears whole or not at all, and what others left is told from what they write."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path

import pytest

from rlbench_pin.datasets import remove_leftovers
from rlbench_pin.datasets.formats.common import new_folder
from rlbench_pin.errors import DatasetConflict


def test_what_killed_exports_left_is_deleted_and_running_ones_are_left_alone(tmp_path: Path) -> None:
    """The lock on a temporary folder says whether somebody writes there; a name with stars means itself."""
    out = tmp_path / "out*"
    dead, alive, foreign = (tmp_path / name for name in (".out*.1.part", ".out*.2.part", ".outer.3.part"))
    for folder in (dead, alive, foreign):
        folder.mkdir()
        (folder / "half").write_bytes(b"x")
    lock = os.open(alive, os.O_RDONLY)
    fcntl.flock(lock, fcntl.LOCK_EX)
    with new_folder(out) as folder:
        assert (dead.exists(), alive.exists(), foreign.exists()) == (False, True, True)
        (folder / "whole").write_bytes(b"y")
    assert [path.name for path in out.iterdir()] == ["whole"]
    os.close(lock)
    with pytest.raises(DatasetConflict, match="Delete it, or choose a new folder"), new_folder(out):
        pass
    with pytest.raises(ZeroDivisionError), new_folder(tmp_path / "other", "file") as folder:
        raise ZeroDivisionError
    with new_folder(tmp_path / "other", "file") as folder:
        (folder / "file").write_bytes(b"z")
        (folder / "more").write_bytes(b"z")
    assert (tmp_path / "other").read_bytes() == b"z"
    assert sorted(path.name for path in tmp_path.iterdir()) == [".out*.2.part", ".outer.3.part", "other", "out*"]


def test_an_abandoned_export_inside_a_dataset_does_not_stop_a_recording(tmp_path: Path) -> None:
    """Leftovers of recordings are files; folders of that kind belong to exports, which delete their own."""
    (tmp_path / ".out.1.part").mkdir()
    (tmp_path / ".episode0.h5.1.part").write_bytes(b"half")
    assert remove_leftovers(tmp_path) == 1
    assert [path.name for path in tmp_path.iterdir()] == [".out.1.part"]
