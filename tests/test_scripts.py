"""The scripts that users are shown run as they stand."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

from rlbench_pin.datasets import read_demo, read_manifest, stored_demos, verify_task
from rlbench_pin.datasets.formats.rlbench_reader import folder_demos
from rlbench_pin.datasets.layout import episode_path

EXPORT = Path(__file__).resolve().parents[1] / "scripts" / "export_demos.py"
TASK = "reach_target"


def export(out: Path) -> str:
    """Run the script for two small episodes and return what it printed."""
    options = ("--tasks", TASK, "--episodes", "2", "--workers", "1", "--image-size", "32")
    command = [sys.executable, str(EXPORT), "--out", str(out), *options]
    result = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
    assert result.returncode == 0, result.stderr
    return result.stdout


@pytest.mark.slow
def test_export_demos(tmp_path: Path) -> None:
    """It records, and every format holds what was recorded; run again, it finds all that is there."""
    printed = export(tmp_path)
    assert "2 recorded now, 0 found, 0 missing" in printed
    assert f"{TASK}: 0 faults" in printed
    assert "the front picture is (32, 32, 3)" in printed
    verify_task(tmp_path / "dataset", TASK, structure=True)
    entries = read_manifest(tmp_path / "dataset", TASK)
    demos = [read_demo(episode_path(tmp_path / "dataset", TASK, e.variation, e.episode), sha256=e.sha256) for e in entries]
    with h5py.File(tmp_path / f"{TASK}.hdf5") as file:
        assert [len(file[f"data/demo_{i}/actions"]) for i in range(2)] == [len(demo) - 1 for demo in demos]
    folders = folder_demos(tmp_path / "rlbench", TASK, -1, -1, random_selection=False)
    for demo, folder in zip(demos, folders, strict=True):
        assert np.array_equal([o.joint_positions for o in demo], [o.joint_positions for o in folder])
        assert np.array_equal([o.wrist_rgb for o in demo], [o.wrist_rgb for o in folder])
    assert (tmp_path / "lerobot").is_dir() == (importlib.util.find_spec("pyarrow") is not None)
    again = export(tmp_path)
    assert "0 recorded now, 2 found, 0 missing" in again
    assert f"{tmp_path / 'rlbench'} is there already" in again
    assert "wrote" not in again
    assert len(stored_demos(tmp_path / "dataset", TASK, -1, -1, random_selection=False)) == 2
