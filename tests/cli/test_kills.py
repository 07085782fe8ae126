"""Recordings, merges and exports that are killed, and two into one folder: the next run ends as if nothing had happened."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from rlbench_pin.cli.main import main
from rlbench_pin.datasets import read_manifest, task_faults
from tests.cli.support import TASK
from tests.demos_for_tests import fill

Capture = pytest.CaptureFixture[str]

UNLISTED = "is not listed in"
"""Said of a whole file that a kill left between its last byte and its line in the manifest; the next merge lists it."""


def start(out: Path, *arguments: str) -> subprocess.Popen[bytes]:
    """Start a recording in a process of its own."""
    return command("record", *arguments, "--out", str(out))


def command(*words: str) -> subprocess.Popen[bytes]:
    """Start a command in a process of its own."""
    program = [sys.executable, "-m", "rlbench_pin.cli.main", *words]
    return subprocess.Popen(program, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def killed(process: subprocess.Popen[bytes], is_time: Callable[[], bool]) -> bool:
    """Kill a process when it is time, and say whether it was at work then."""
    deadline = time.monotonic() + 120
    while process.poll() is None and not is_time():
        assert time.monotonic() < deadline, "the moment did not come"
        time.sleep(0.0005)
    process.send_signal(signal.SIGKILL)
    process.communicate(timeout=60)
    return process.returncode == -signal.SIGKILL


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A dataset that takes a moment to copy."""
    return fill(tmp_path_factory.mktemp("data") / "data", range(24), frames=40)


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


@pytest.mark.simulation
def test_a_merge_that_is_killed_is_completed_by_the_next(data: Path, tmp_path: Path, capsys: Capture) -> None:
    """At its first file, at its first listed episode, in the middle, near the end: what is there is sound at every moment."""
    calm, rough = tmp_path / "calm", tmp_path / "rough"
    assert main(["dataset", "merge", str(data), "--out", str(calm)]) == 0
    moments: list[Callable[[], bool]] = [
        lambda: rough.exists(),
        lambda: any(rough.rglob(".episode*.part")),
        lambda: (rough / TASK / ".manifest.journal").exists(),
        lambda: stored(rough) > 12,
        lambda: stored(rough) > 20,
    ]
    hits = 0
    for is_time in moments:
        hits += killed(command("dataset", "merge", str(data), "--out", str(rough)), is_time)
        if (rough / TASK / "manifest.json").exists():
            assert [fault for fault in task_faults(rough, TASK) if UNLISTED not in str(fault)] == []
    assert hits >= 1  # a loaded machine may let a merge finish between two looks
    for part in ("variation0/episodes/.episode3.h5.1.part", "variation0/.manifest.json.2.part"):  # of others that were killed
        (rough / TASK / part).parent.mkdir(parents=True, exist_ok=True)
        (rough / TASK / part).write_bytes(b"half")
    assert main(["dataset", "merge", str(data), "--out", str(rough)]) == 0
    assert "episodes copied" in capsys.readouterr().out
    assert_same(rough, calm)
    assert not list(rough.rglob(".manifest.journal"))
    assert main(["dataset", "merge", str(data), "--out", str(rough)]) == 0
    assert "0 episodes copied" in capsys.readouterr().out


@pytest.mark.simulation
@pytest.mark.parametrize(("kind", "files"), [("rlbench", "*.pkl"), ("robomimic", "*.hdf5")])
def test_an_export_that_is_killed_leaves_nothing_in_the_way(data: Path, tmp_path: Path, kind: str, files: str) -> None:
    """The next one to the same place works, and deletes what was left."""
    out, hits = tmp_path / "out", 0
    moments: list[Callable[[], bool]] = [
        lambda: bool(parts(tmp_path)),
        lambda: any(any(part.rglob(files)) for part in parts(tmp_path)),
    ]
    for is_time in moments:
        hits += killed(command("dataset", "export", kind, str(data), str(out)), is_time)
        assert not out.exists()
        assert len(parts(tmp_path)) == 1
    assert hits == 2
    assert main(["dataset", "export", kind, str(data), str(out)]) == 0
    assert out.is_file() if kind == "robomimic" else len(list(out.rglob("low_dim_obs.pkl"))) == 24
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def parts(folder: Path) -> list[Path]:
    """Return the temporary folders of exports."""
    return list(folder.glob(".out.*.part"))


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
