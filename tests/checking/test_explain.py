"""Failures say why, with evidence and an image."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.checking.explain import evidence_lines, explain_failure
from rlbench_pin.cli.main import main
from rlbench_pin.errors import NoIkSolution
from rlbench_pin.planning.problems import read_problem


def test_success_needs_no_explanation() -> None:
    """One line for a demonstration that succeeds."""
    assert explain_failure("reach_target", 0, 0)[0].endswith("succeeds.")


def test_a_task_file_is_explained_as_well(tmp_path: Path) -> None:
    """A path stands for the task in that file."""
    assert main(["new", "touch_it", "--out", str(tmp_path)]) == 0
    (line,) = explain_failure(str(tmp_path / "touch_it.py"), 0, 0)
    assert line == "touch_it seed 0 variation 0 attempt 0: the demonstration succeeds."


@pytest.mark.simulation
def test_a_failure_is_explained_and_drawn(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The reason, what is known, and the scene at that moment."""

    def refuse(*args: object, **options: object) -> None:
        raise NoIkSolution(np.array([1.0, 0, 1, 0, 0, 0, 1]), 0.2, 0.1, 40, np.array([0.8, 0, 1, 0, 0, 0, 1]))

    monkeypatch.setattr("rlbench_pin.planning.planner.retime", refuse)
    lines = explain_failure("reach_target", 0, 0, tmp_path / "a.png")
    assert "  reason: unreachable" in lines
    assert any(line.startswith("  nearest: [0.8") for line in lines)
    assert (tmp_path / "a.png").read_bytes()[:4] == b"\x89PNG"


def test_only_planning_errors_have_evidence() -> None:
    """Other errors say what they say."""
    assert evidence_lines(ValueError("no")) == []


def test_problems_are_exported_and_read_back(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Each segment is a file with a problem."""
    assert main(["problems", "export", "reach_target", "--episodes", "1", "--out", str(tmp_path)]) == 0
    files = sorted(tmp_path.glob("reach_target_*.json"))
    assert files
    assert str(len(files)) in capsys.readouterr().out
    problem = read_problem(files[0])
    assert problem.goal is not None
    np.testing.assert_allclose(problem.model().tip_pose(problem.goal)[:3], problem.poses[0][:3], atol=1e-5)  # type: ignore[index, arg-type]
    assert main(["problems", "import", "reach_target"]) == 2
