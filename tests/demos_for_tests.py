"""Made-up demonstrations for the tests of datasets and of the command line."""

from __future__ import annotations

import errno
import json
import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rlbench_pin.datasets import DatasetWriter
from rlbench_pin.observation import Demo, Observation


def make_demo(frames: int = 5, seed: int = 3, variation: int = 0, task: str = "reach_target") -> Demo:
    """Return a demo with every kind of content that the format must carry."""
    rng = np.random.default_rng(seed)
    return Demo(
        [_observation(i, rng) for i in range(frames)],
        random_seed=seed,
        num_reset_attempts=2,
        variation_number=variation,
        instructions=["reach the red ball", "touch the ball that is red"],
        state={"body/ball/pose": rng.normal(size=7), "empty": np.zeros((0, 7)), "count": np.array([4], dtype=np.int64)},
        versions={"rlbench_pin": "0.1.0"},
        attempt=1,
        task_name=task,
    )


def fill(root: Path, seeds: range, frames: int = 2, variation: int = 0) -> Path:
    """Write an episode of `make_demo` for each seed and return the folder."""
    for seed in seeds:
        DatasetWriter(root, compression="lzf").add(make_demo(frames=frames, seed=seed, variation=variation))
    return root


def edit_manifest(root: Path, **changes: object) -> None:
    """Change the second entry of the manifest of `reach_target`."""
    path = root / "reach_target" / "manifest.json"
    content = json.loads(path.read_text())
    content["episodes"][1].update(changes)
    path.write_text(json.dumps(content))


def _observation(index: int, rng: np.random.Generator) -> Observation:
    return Observation(
        front_rgb=rng.integers(0, 256, (12, 16, 3), dtype=np.uint8),
        front_depth=rng.random((12, 16), dtype=np.float32),
        front_mask=rng.integers(0, 90, (12, 16), dtype=np.int32),
        wrist_point_cloud=rng.random((12, 16, 3), dtype=np.float32),
        joint_positions=rng.normal(size=7),
        joint_velocities=np.full(7, np.nan) if index == 2 else rng.normal(size=7),
        gripper_open=float(index % 2),
        gripper_pose=rng.normal(size=7),
        gripper_matrix=np.eye(4),
        task_low_dim_state=np.zeros(0),
        misc=_misc(index, rng),
    )


def _misc(index: int, rng: np.random.Generator) -> dict[str, Any]:
    misc: dict[str, Any] = {
        "variation_index": 3,
        "front_camera_intrinsics": np.diag([-175.84, -175.84, 1.0]),
        "front_camera_near": 0.01,
        "joint_poses": [rng.normal(size=7) for _ in range(7)],
        "mask_names": {0: "nothing", 61: "ball"},
        "descriptions": ["reach the red ball"],
        "nested": {"pair": (1, 2.5), "array": np.arange(3, dtype=np.int32), "yes": True, "none": None},
        "scalar": np.float32(index / 3),
        "note": "naïve ✓",
    }
    if index:
        misc["joint_position_action"] = rng.normal(size=8)
    if index == 1:
        misc["ragged"] = np.zeros(2)
    if index == 2:
        misc["ragged"] = np.zeros(3)
    return misc


@contextmanager
def mounted(folder: Path, kilobytes: int) -> Iterator[Path]:
    """A small disk of its own at a new folder, where this machine lets tests mount one; otherwise the test is skipped."""
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "tmpfs", str(folder)]
    if os.geteuid() != 0 or subprocess.run(command, check=False).returncode:
        pytest.skip("no disk can be mounted here")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)  # FFmpeg keeps a file open whose first byte was refused


def assert_equal(a: Any, b: Any) -> None:
    """Compare values of any depth: types, shapes, bits."""
    assert type(a) is type(b)
    if isinstance(a, np.ndarray):
        assert (a.shape, a.dtype, a.tobytes()) == (b.shape, b.dtype, b.tobytes())
    elif isinstance(a, dict):
        assert a.keys() == b.keys()
        for key in a:
            assert_equal(a[key], b[key])
    elif isinstance(a, list | tuple):
        assert len(a) == len(b)
        for left, right in zip(a, b):
            assert_equal(left, right)
    else:
        assert a == b


def simulate_full_disk(monkeypatch: pytest.MonkeyPatch, after: int) -> None:
    """Simulate a disk that is full after so many files and lines have reached it."""
    calls, real = iter(range(1000)), os.fsync

    def fsync(file: int) -> None:
        if next(calls) >= after:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        real(file)

    monkeypatch.setattr(os, "fsync", fsync)
