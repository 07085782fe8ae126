"""Disks that are full or read-only, for all that is written beside a recording: exports, merged datasets, lists of seeds.

`tests/recording/test_record.py` has those of recordings. The disks are real where this machine lets tests mount one;
elsewhere `fsync` is replaced by one that fails, or the kernel lets no file grow beyond a size.
"""

from __future__ import annotations

import errno
import importlib.util
import resource
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from rlbench_pin.cli.main import main
from rlbench_pin.datasets import DatasetWriter, has_manifest, read_manifest, task_faults
from rlbench_pin.datasets.formats import ExportFormat, find_exporter
from rlbench_pin.datasets.merge import merge_datasets
from rlbench_pin.errors import StorageError
from rlbench_pin.observation import Demo, Observation
from rlbench_pin.recording.rerender import seeds_of, write_seeds
from tests.demos_for_tests import mounted, simulate_full_disk

Capture = pytest.CaptureFixture[str]
TASK = "reach_target"
NEEDS = {"lerobot": "pyarrow", "zarr": "zarr"}
SIZE = 500
"""Of the disk [kB]."""


def noisy_demo(seed: int) -> Demo:
    """A demo whose images no format makes small."""
    rng = np.random.default_rng(seed)
    frames = []
    for index in range(12):
        frame = Observation(
            front_rgb=rng.integers(0, 256, (64, 64, 3), dtype=np.uint8),
            joint_positions=rng.normal(size=7),
            gripper_open=1.0,
            gripper_pose=rng.normal(size=7),
        )
        if index:
            frame.misc["joint_position_action"] = rng.normal(size=8)
        frames.append(frame)
    return Demo(frames, random_seed=seed, variation_number=0, instructions=["reach"], task_name=TASK)


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six episodes, together larger than the disk."""
    root = tmp_path_factory.mktemp("data")
    for seed in range(6):
        DatasetWriter(root).add(noisy_demo(seed))
    return root


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Path]:
    """A disk that is too small for anything that the tests write."""
    with mounted(tmp_path / "disk", SIZE) as folder:
        yield folder


def leave_free(disk: Path, kilobytes: int) -> None:
    """Fill the disk but for so much [kB]."""
    (disk / "ballast").write_bytes(bytes(1024 * (SIZE - kilobytes)))


@contextmanager
def short_files(size: int) -> Iterator[None]:
    """Let no file grow beyond so many bytes: the kernel refuses in the middle of a write, as a full disk does."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def exporter(name: ExportFormat) -> Callable[..., Path]:
    """Return the function that writes a format; the test is skipped without the library that it needs."""
    if name in NEEDS and importlib.util.find_spec(NEEDS[name]) is None:
        pytest.skip(f"the extra '{name}' is not installed")
    return find_exporter(name)


# Real ones ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("free", [0, 12, 100, 240])
@pytest.mark.parametrize("name", get_args(ExportFormat))
def test_an_export_to_a_full_disk(disk: Path, data: Path, name: ExportFormat, free: int) -> None:
    """Wherever in its course the disk is full, an export says so, and leaves nothing."""
    export = exporter(name)
    leave_free(disk, free)
    with pytest.raises(StorageError, match=r"disk/out.*No space left.*Free some space") as caught:
        export(data, disk / "out")
    assert caught.value.errno == errno.ENOSPC
    assert [path.name for path in disk.iterdir()] == ["ballast"]


@pytest.mark.parametrize("free", [0, 300])
def test_merging_onto_a_full_disk(disk: Path, data: Path, free: int) -> None:
    """What was copied before is whole and listed; merging again, with enough space, completes it."""
    leave_free(disk, free)
    with pytest.raises(StorageError, match=r"No space left.*Free some space"):
        merge_datasets([data], disk / "out")
    assert task_faults(disk / "out", TASK) == [] if free else not list(disk.rglob("*.h5"))
    assert not list(disk.rglob("*.part"))
    (disk / "ballast").unlink()
    subprocess.run(["mount", "-o", "remount,size=2000k", str(disk)], check=True)
    merge_datasets([data], disk / "out")
    assert read_manifest(disk / "out", TASK) == read_manifest(data, TASK)
    assert task_faults(disk / "out", TASK) == []


def test_seeds_onto_a_full_disk(disk: Path, data: Path) -> None:
    """The file that was there before stays as it was."""
    (disk / "seeds.json").write_text("before")
    leave_free(disk, 4)
    with pytest.raises(StorageError, match=r"seeds\.json.*No space left"):
        write_seeds(disk / "seeds.json", seeds_of(data) * 1000)
    assert (disk / "seeds.json").read_text() == "before"


def test_the_commands_say_what_to_do(disk: Path, data: Path, capsys: Capture) -> None:
    """On a full disk and on a read-only one: one line with the path and the remedy, exit code 1, no traceback."""
    leave_free(disk, 0)
    small = ("--episodes", "1", "--workers", "0", "--products")
    commands = (
        ("record", TASK, "--out", f"{disk}/recorded", *small),
        ("dataset", "merge", str(data), "--out", f"{disk}/merged"),
        ("dataset", "seeds", str(data), f"{disk}/seeds.json"),
        ("dataset", "export", "robomimic", str(data), f"{disk}/exported"),
    )
    for command in commands:
        assert main(command) == 1, command
        assert "No space left on device. Free some space" in capsys.readouterr().err, command
    subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
    for command in commands:
        assert main(command) == 1, command
        err = capsys.readouterr().err
        assert str(disk) in err, command
        assert "The disk is read-only: choose another folder" in err, command


# Simulated ones -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [600, 5000])
@pytest.mark.parametrize("name", get_args(ExportFormat))
def test_an_export_whose_files_are_refused(tmp_path: Path, data: Path, name: ExportFormat, size: int) -> None:
    """Refused in the middle of a file, every format says so with the path, and leaves nothing."""
    export = exporter(name)
    with short_files(size), pytest.raises(StorageError, match=r"'.*/out' cannot be written: File too large") as caught:
        export(data, tmp_path / "out")
    assert (caught.value.path, caught.value.errno) == (tmp_path / "out", errno.EFBIG)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("after", [0, 1, 4, 5, 12])
def test_merging_while_the_disk_fills_up(tmp_path: Path, data: Path, monkeypatch: pytest.MonkeyPatch, after: int) -> None:
    """Whenever it is full, the file is named, every episode that is there is whole, and merging again completes it."""
    out, whole = tmp_path / "out", {path.read_bytes() for path in data.rglob("*.h5")}
    simulate_full_disk(monkeypatch, after)
    with pytest.raises(StorageError, match=rf"'{out}/{TASK}/.*No space left.*Free some space") as caught:
        merge_datasets([data], out)
    monkeypatch.undo()
    assert caught.value.errno == errno.ENOSPC
    assert {path.read_bytes() for path in out.rglob("*.h5")} <= whole
    assert len(read_manifest(out, TASK)) == after // 2
    assert not list(tmp_path.rglob("*.part"))
    merge_datasets([data], out)
    assert read_manifest(out, TASK) == read_manifest(data, TASK)
    assert task_faults(out, TASK) == []


def test_merging_leaves_no_half_of_an_episode(tmp_path: Path, data: Path) -> None:
    """Refused in the middle of its first file, a merge leaves no file."""
    with short_files(5000), pytest.raises(StorageError, match=r"episode0\.h5' cannot be written"):
        merge_datasets([data], tmp_path)
    assert not [*tmp_path.rglob("*.h5"), *tmp_path.rglob("*.part")]
    assert not has_manifest(tmp_path, TASK)


def test_seeds_while_the_disk_fills_up(tmp_path: Path, data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Refused at the end or in the middle, the list that was there before stays as it was, and nothing lies beside it."""
    file, seeds = tmp_path / "seeds.json", seeds_of(data)
    file.write_text("before")
    with short_files(200), pytest.raises(StorageError, match=rf"'{file}' cannot be written: File too large"):
        write_seeds(file, seeds)
    simulate_full_disk(monkeypatch, 0)
    with pytest.raises(StorageError, match=rf"'{file}' cannot be written: No space left.*Free some space"):
        write_seeds(file, seeds)
    assert [path.read_text() for path in tmp_path.iterdir()] == ["before"]


def test_the_commands_say_so(tmp_path: Path, data: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    """One line with the path and the remedy, exit code 1."""
    simulate_full_disk(monkeypatch, 0)
    for command in (("merge", str(data), "--out", f"{tmp_path}/out"), ("seeds", str(data), f"{tmp_path}/out")):
        assert main(["dataset", *command]) == 1, command
        err = capsys.readouterr().err.splitlines()[-1]
        assert err.startswith(f"rlbench-pin: '{tmp_path}/out"), command
        assert "No space left on device. Free some space" in err, command
