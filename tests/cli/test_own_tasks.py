"""Every command takes a task file in the place of a name."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.support import exit_code

pytestmark = pytest.mark.simulation
Capture = pytest.CaptureFixture[str]


@pytest.fixture
def mine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A task file in the folder `mine` below the current one, named as a user names it."""
    monkeypatch.chdir(tmp_path)
    assert exit_code("new", "touch_it", "--out", "mine") == 0
    return "mine/touch_it.py"


def test_check_view_demo_and_video(mine: str, capsys: Capture) -> None:
    """Results are called like the task, not like its path."""
    assert exit_code("check", mine, "--episodes", "2", "--no-contract") == 0
    assert "touch_it" in capsys.readouterr().out
    assert exit_code("check", mine, "--task-file", mine, "--episodes", "1", "--no-contract", "--workers", "2") == 0
    assert exit_code("view", mine, "--size", "32") == 0
    assert Path("out/view/touch_it.png").is_file()
    assert exit_code("demo", mine, "--no-video", "--image-size", "16", "16", "--cameras", "front", "--out", "d") == 0
    assert list(Path("d/touch_it").glob("variation*/episodes/*.h5"))
    assert Path("d/touch_it/task_file/touch_it.toml").is_file()
    assert exit_code("video", mine, "--size", "64", "64", "--out", "videos") == 0
    assert Path("videos/touch_it.mp4").is_file()


def test_problems(mine: str, capsys: Capture) -> None:
    """Its segments become problems."""
    assert exit_code("problems", "export", mine, "--episodes", "1", "--out", "p") == 0
    assert "touch_it: 1 problems in p" in capsys.readouterr().out
    assert [p.name for p in Path("p").iterdir()] == ["touch_it_0000_segment0.json"]


def test_record_replay_and_rerender(mine: str, capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    """Together with a task of the library; from another folder only when the user trusts the copy or names the file."""
    assert exit_code("record", f"{mine},reach_target", "--episodes", "1", "--workers", "0", "--products", "--out", "data") == 0
    assert json.loads(Path("data/recording.json").read_text())["tasks"] == ["touch_it", "reach_target"]
    Path("elsewhere").mkdir()
    Path("data").rename("elsewhere/data")
    monkeypatch.chdir("elsewhere")
    for command in (["replay", "data"], ["record", "--resume", "--out", "data"], ["dataset", "rerender", "data", "--out", "r"]):
        capsys.readouterr()
        assert exit_code(*command) == 1
        assert "--trust-task-files" in capsys.readouterr().err
    assert exit_code("replay", "data", "--trust-task-files") == 0
    assert exit_code("replay", "data", "--task-file", f"../{mine}") == 0
    assert exit_code("record", "--resume", "--out", "data", "--workers", "0", "--trust-task-files") == 0
    small = ("--image-size", "16", "16", "--cameras", "front", "--workers", "0")
    assert exit_code("dataset", "rerender", "data", "--out", "r", *small, "--task-file", f"../{mine}") == 0
    assert exit_code("dataset", "verify", "r") == 0
    assert exit_code("dataset", "export", "robomimic", "r", "r.hdf5", "--tasks", "touch_it") == 0


def test_broken_files_are_misuse_or_failure_never_a_trace(mine: str, capsys: Capture) -> None:
    """Every command says what is wrong with the file."""
    Path("mine/broken.py").write_text("import no_such_module\n")
    for command in (["view"], ["demo"], ["check"], ["video"], ["record"], ["problems", "export"]):
        for file, says in {"mine/broken.py": "no_such_module", "mine/none.py": "does not exist"}.items():
            capsys.readouterr()
            assert exit_code(*command, file) in (1, 2)
            assert says in capsys.readouterr().err
