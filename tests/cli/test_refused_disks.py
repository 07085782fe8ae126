"""Commands whose folder cannot be written: refused before the work where that can be seen, nothing half-written, one line."""

from __future__ import annotations

import resource
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.cli import demo as demo_command
from rlbench_pin.cli import video as video_command
from rlbench_pin.datasets import VideoWriter
from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.errors import StorageError
from rlbench_pin.planning.problems import PlanningProblem, write_problem
from rlbench_pin.recording.video import Orbit
from rlbench_pin.scene.snapshot import WorldSnapshot
from tests.cli.support import TASK, exit_code
from tests.demos_for_tests import mounted, simulate_full_disk

Capture = pytest.CaptureFixture[str]
WRITERS = [
    ("view", TASK, "--out", "OUT/image.png"),
    ("video", TASK, "--out", "OUT"),
    ("video", TASK, "--grid", "--out", "OUT"),
    ("new", "touch_it", "--out", "OUT"),
    ("check", TASK, "--out", "OUT"),
    ("check", TASK, "--json", "OUT/report.json"),
    ("problems", "export", TASK, "--out", "OUT"),
    ("evaluate", "expert", "--tasks", TASK, "--out", "OUT/all.json"),
    ("demo", TASK, "--out", "OUT"),
    ("record", TASK, "--workers", "0", "--out", "OUT"),
]
"""Every command that writes, and where."""


def at(folder: Path | str, words: tuple[str, ...]) -> list[str]:
    """Return a command that writes to a folder."""
    return [word.replace("OUT", str(folder)) for word in words]


@contextmanager
def short_files(size: int) -> Iterator[None]:
    """Let no file grow beyond so many bytes: the kernel refuses in the middle of a write, as a full disk does."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize("words", WRITERS, ids=" ".join)
@pytest.mark.parametrize("place", ["below a file", "/proc", "long"])
def test_folders_that_cannot_be(words: tuple[str, ...], place: str, tmp_path: Path, capsys: Capture) -> None:
    """A file in the path, a file system that takes none, a name that is too long: said at once, with the path."""
    (tmp_path / "file").write_text("before")
    folder = {"below a file": tmp_path / "file" / "out", "/proc": Path("/proc/none"), "long": tmp_path / ("x" * 300)}[place]
    assert exit_code(*at(folder, words)) == 1
    out, err = capsys.readouterr()
    (line,) = err.strip().splitlines()
    if not (place == "long" and "is too long: names have at most 255 bytes" in line):
        assert line.startswith(f"rlbench-pin: '{folder}")
        assert "cannot be written" in line
    assert out == ""
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
    assert (tmp_path / "file").read_text() == "before"


@pytest.mark.parametrize("words", WRITERS, ids=" ".join)
def test_a_disk_that_is_read_only(words: tuple[str, ...], tmp_path: Path, capsys: Capture) -> None:
    """Where this machine lets tests mount one."""
    with mounted(tmp_path / "disk", 500) as disk:
        subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
        assert exit_code(*at(disk, words)) == 1
        assert "The disk is read-only: choose another folder" in capsys.readouterr().err


@pytest.mark.parametrize("words", [WRITERS[0], WRITERS[5], WRITERS[7]], ids=" ".join)
def test_a_folder_where_the_file_belongs(words: tuple[str, ...], tmp_path: Path, capsys: Capture) -> None:
    """It is not replaced."""
    Path(at(tmp_path, words)[-1]).mkdir()
    assert exit_code(*at(tmp_path, words)) == 1
    assert "A folder has that name: choose another name" in capsys.readouterr().err


@pytest.mark.parametrize("after", [0, 1])
def test_new_writes_both_files_or_none(after: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    """A disk that is full at the first or the second."""
    simulate_full_disk(monkeypatch, after)
    assert exit_code("new", "touch_it", "--out", str(tmp_path)) == 1
    assert "No space left on device. Free some space" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_problem_is_whole_or_not_there(tmp_path: Path) -> None:
    """Refused in the middle, nothing is left, and what was there stays."""
    world = WorldSnapshot((), np.zeros(7), np.zeros(2), ())
    problem = PlanningProblem("empty", world, np.ones(7))
    (tmp_path / "empty.json").write_text("before")
    with short_files(20), pytest.raises(StorageError, match=r"empty\.json' cannot be written: File too large"):
        write_problem(problem, tmp_path / "empty.json")
    assert [path.read_text() for path in tmp_path.iterdir()] == ["before"]


@pytest.mark.parametrize("words", [WRITERS[1], WRITERS[2]], ids=" ".join)
def test_a_video_on_a_disk_that_fills_up(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    """FFmpeg is refused in the middle of the video: the path is named, and no half of it is left."""
    noise = np.random.default_rng(0)

    def play(self: video_command.Video, task: TaskEnvironment, orbit: Orbit, add: object) -> None:
        for _ in range(40):
            add(noise.integers(0, 256, (orbit.size[1], orbit.size[0], 3), dtype=np.uint8))  # type: ignore[operator]

    monkeypatch.setattr(video_command.Video, "_play", play)
    with short_files(200_000):
        assert exit_code(*at(tmp_path / "videos", words)) == 1
    err = capsys.readouterr().err
    assert f"'{tmp_path}/videos/" in err
    assert ".mp4' cannot be written: File too large" in err
    assert list((tmp_path / "videos").iterdir()) == []


def test_a_demonstration_on_a_disk_that_fills_up(tmp_path: Path, capsys: Capture) -> None:
    """The video beside it is refused first; neither video nor episode is left."""
    with short_files(20_000):
        assert exit_code("demo", TASK, "--out", str(tmp_path / "data"), "--image-size", "8", "8") == 1
    assert "cannot be written: File too large" in capsys.readouterr().err
    assert [path for path in (tmp_path / "data").rglob("*") if path.suffix in (".mp4", ".h5", ".part")] == []
    assert demo_command.RecordDemos(TASK).episodes == 1


def test_a_journal_on_a_disk_that_fills_up(tmp_path: Path, capsys: Capture) -> None:
    """A check names the file; with space, the same command goes on."""
    words = ("check", TASK, "--episodes", "2", "--no-contract", "--no-images", "--out", str(tmp_path))
    with short_files(100):
        assert exit_code(*words) == 1
    assert "trials.jsonl' cannot be written: File too large" in capsys.readouterr().err
    assert exit_code(*words) == 0


@pytest.mark.parametrize("name", ["a:b/c:d.mp4", "http:/x.mp4", "file:x.mp4", "%d.mp4", "-x.mp4", "a b\n.mp4", "ü.mp4"])
def test_videos_with_odd_names(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """FFmpeg takes no part of a path for a protocol or a pattern."""
    monkeypatch.chdir(tmp_path)
    with VideoWriter(Path(name), (32, 32)) as video:
        video.add(np.zeros((32, 32, 3), dtype=np.uint8))
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == [tmp_path / name]
