"""`rlbench-pin replay` as a user types it."""

from __future__ import annotations

from pathlib import Path

import pytest

from rlbench_pin.datasets import episode_files, read_demo, write_demo
from tests.cli.support import RECORD, TASK, exit_code

Capture = pytest.CaptureFixture[str]
MonkeyPatch = pytest.MonkeyPatch


def test_replay_says_what_still_succeeds(tmp_path: Path, capsys: Capture) -> None:
    """A recorded episode reaches its goal again; one whose actions were stilled does not, and the exit code says so."""
    assert exit_code(*RECORD, "--episodes", "1", "--out", str(tmp_path)) == 0
    (path,) = episode_files(tmp_path, TASK)
    assert exit_code("replay", str(tmp_path)) == 0
    assert f"reached  {path}" in capsys.readouterr().out
    demo = read_demo(path)
    for observation in demo[1:]:
        observation.misc["joint_position_action"] = demo[1].misc["joint_position_action"]
    changed = write_demo(demo, tmp_path / "changed.h5")
    assert exit_code("replay", str(changed)) == 1
    assert f"MISSED   {changed}" in capsys.readouterr().out
    write_demo(demo, path)
    assert exit_code("replay", str(tmp_path)) == 1
    assert path.name in capsys.readouterr().err, "it is not the file that its manifest lists"
    assert exit_code("replay", str(tmp_path / "nothing.h5")) == 1
    assert "does not exist" in capsys.readouterr().err
