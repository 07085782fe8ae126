"""`rlbench-pin evaluate` as a user types it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rlbench_pin.cli.main import main

POLICY = ("evaluate", "noop", "--tasks", "reach_target", "--episodes", "2", "--max-seconds", "0.5", "--workers", "0", "--out")


@pytest.mark.simulation
def test_evaluate_a_policy(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A row for the task, the results file, videos of failures that have their seeds in their names."""
    out = tmp_path / "noop.json"
    assert main((*POLICY, str(out), "--videos", "1")) == 0
    printed = capsys.readouterr().out
    assert "reach_target    0.0 %" in printed
    episodes = json.loads(out.read_text())["episodes"]
    assert [episode["end"] for episode in episodes] == ["seconds", "seconds"]
    videos = [path.name for path in (tmp_path / "noop_videos").iterdir()]
    assert videos == [f"reach_target_{episodes[0]['seed']}_seconds.mp4"]
    assert videos[0] in printed
    assert main((*POLICY, str(out))) == 1
    assert "is there already" in capsys.readouterr().err
    assert main((*POLICY, str(out), "--resume")) == 0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("rndom", "--tasks", "reach_target"), "Did you mean 'random'"),
        (("noop", "--tasks", "reach_targt"), "Did you mean 'reach_target'"),
        (("noop", "--tasks", ","), "No task was named"),
        (("noop", "--videos", "-1"), "--videos"),
        (("noop", "--workers", "-1"), "--workers"),
        (("noop", "--episodes", "0"), "episodes"),
        (("noop", "--max-seconds", "0"), "max_seconds"),
        (("noop", "--robot", "pandda"), "panda"),
        (("nowhere.py:make", "--tasks", "reach_target"), "nowhere.py"),
        (("noop", "--tasks", "FS95_V1"), "not built"),
    ],
)
def test_misuse_of_policies_is_explained(
    arguments: tuple[str, ...], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nothing is written, and no traceback is shown."""
    assert main(("evaluate", *arguments, "--out", str(tmp_path / "out" / "x.json"))) in (1, 2)
    err = capsys.readouterr().err
    assert words in err
    assert "Traceback" not in err
    assert list(tmp_path.rglob("*.json*")) == []
