"""Recordings that are killed, and two into one folder: the dataset is the one that an undisturbed recording makes."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rlbench_pin.cli.main import main
from rlbench_pin.datasets import read_manifest, task_faults
from tests.cli.support import TASK

Capture = pytest.CaptureFixture[str]


def start(out: Path, *arguments: str) -> subprocess.Popen[bytes]:
    """Start a recording in a process of its own."""
    command = [sys.executable, "-m", "rlbench_pin.cli.main", "record", *arguments, "--out", str(out)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def stored(out: Path) -> int:
    """Return how many episodes lie in a folder."""
    return len(list(out.glob(f"{TASK}/variation*/episodes/episode*.h5")))


def wait_for(out: Path, count: int) -> None:
    """Wait until so many episodes are stored."""
    deadline = time.monotonic() + 120
    while stored(out) < count:
        assert time.monotonic() < deadline, f"no {count} episodes in time"
        time.sleep(0.01)


def assert_same(one: Path, other: Path) -> None:
    """Both hold the same episodes, byte for byte, and nothing is left of what was not finished."""
    manifest = Path(TASK) / "manifest.json"
    assert (one / manifest).read_bytes() == (other / manifest).read_bytes()
    assert task_faults(one, TASK) == []
    assert not list(one.rglob("*.part"))


@pytest.mark.slow
def test_five_kills(tmp_path: Path) -> None:
    """SIGKILL while the program starts, while its workers do, between episodes, with one worker, two, and none."""
    plan, calm, rough = (TASK, "--episodes", "30", "--products"), tmp_path / "calm", tmp_path / "rough"
    assert main(["record", *plan, "--workers", "0", "--out", str(calm)]) == 0
    for workers, episodes, delay in (("2", 0, 0.4), ("2", 0, 2.0), ("1", 4, 0.0), ("2", 10, 0.2), ("0", 16, 0.1)):
        process = start(rough, *plan, "--resume", "--workers", workers)
        wait_for(rough, episodes)
        time.sleep(delay)
        process.send_signal(signal.SIGKILL)
        process.communicate(timeout=60)
        if stored(rough):
            assert task_faults(rough, TASK) == []
    assert 0 < len(read_manifest(rough, TASK)) < 30
    assert main(["record", *plan, "--resume", "--workers", "2", "--out", str(rough)]) == 0
    assert_same(rough, calm)


def test_two_recordings_into_one_folder(tmp_path: Path, capsys: Capture) -> None:
    """The second is refused and says why; the first ends as if it had been alone; then the folder is free."""
    plan, alone, shared = (TASK, "--episodes", "16", "--products"), tmp_path / "alone", tmp_path / "shared"
    process = start(shared, *plan, "--workers", "1")
    wait_for(shared, 1)
    for more in ((), ("--resume",)):
        assert main(["record", *plan, *more, "--workers", "0", "--out", str(shared)]) == 1
        assert f"Another recording or merge into '{shared}' is running" in capsys.readouterr().err
    process.communicate(timeout=120)
    assert process.returncode == 0
    assert main(["record", *plan, "--workers", "0", "--out", str(alone)]) == 0
    assert_same(shared, alone)
    assert main(["record", *plan, "--resume", "--workers", "0", "--out", str(shared)]) == 0
    assert "0 recorded now" in capsys.readouterr().out
