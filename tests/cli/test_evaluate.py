"""`rlbench-pin evaluate` as a user types it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rlbench_pin.cli.main import main


def test_evaluate_compares_controllers(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A table on stdout, the same figures in the file."""
    file = tmp_path / "controllers.json"
    names = ("TrajectoryTracker", "VelocityFollowing")
    arguments = ("evaluate", "--controllers", "--tasks", "reach_target", "--only", *names, "--json", str(file))
    assert main(arguments) == 0
    out = capsys.readouterr().out
    content = json.loads(file.read_text())
    assert content["tasks"] == ["reach_target"]
    assert {s["controller"] for s in content["controllers"]} == {"the plan itself", *names}
    for summary in content["controllers"]:
        assert summary["controller"] in out
        assert sum(summary["violations"].values()) == 0


@pytest.mark.parametrize(
    "arguments", [(), ("--controllers", "--tasks", "reach_targt"), ("--controllers", "--only", "TrajectoryTraker")]
)
def test_misuse_is_explained(arguments: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    """Nothing to evaluate, an unknown task, an unknown controller."""
    assert main(("evaluate", *arguments)) == 2
    assert capsys.readouterr().err
