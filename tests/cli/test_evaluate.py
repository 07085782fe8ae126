"""`rlbench-pin evaluate` as a user types it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rlbench_pin.cli.main import main
from tests.evaluation.run import policies

POLICY = ("evaluate", "noop", "--tasks", "reach_target", "--episodes", "2", "--max-seconds", "0.5", "--workers", "0", "--out")
FILE = Path(policies.__file__)


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
    assert "exists already" in capsys.readouterr().err
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
        ((f"{FILE}", "--tasks", "reach_target"), f"{FILE}:NAME"),
        ((f"{FILE}", "--tasks", "reach_target"), "Still, EndsWorker, WrongShape, Poses"),
        (("nowhere.py", "--tasks", "reach_target"), "nowhere.py:NAME"),
        (("nowhere.py:make", "--tasks", "reach_target"), "nowhere.py"),
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


def test_the_policy_is_looked_at_before_the_place_of_the_results(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Whoever has mistyped both hears of the policy first."""
    (tmp_path / "x.json").touch()
    assert main(("evaluate", "rndom", "--tasks", "reach_target", "--out", str(tmp_path / "x.json"))) == 2
    assert "Did you mean 'random'" in capsys.readouterr().err


def test_the_first_fault_of_each_kind_is_printed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """By `evaluate` and by `results`, with what was wrong and where."""
    out = str(tmp_path / "x.json")
    words = ("--tasks", "reach_target", "--episodes", "2", "--max-seconds", "0.5", "--workers", "0", "--out", out)
    assert main(("evaluate", f"{FILE}:WrongShape", *words)) == 0
    printed = capsys.readouterr().out
    assert main(("results", out)) == 0
    for text in (printed, capsys.readouterr().out):
        assert (
            text.count(
                "First 'wrong answer' (reach_target, seed 9007199254740992): an action has the shape (5,); it must be (8,)"
            )
            == 1
        )
    assert main(("results", out, "--json")) == 0
    (fault,) = json.loads(capsys.readouterr().out)["results"][0]["first_faults"]
    assert (fault["fault"], fault["task"]) == ("wrong answer", "reach_target")


def test_a_factory_that_fails_says_why_in_the_first_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Class, message and place of the error; then the traceback without frames of this package."""
    (tmp_path / "mine.py").write_text("def make():\n    raise RuntimeError('no weights:\\nnowhere')\n")
    words = ("--tasks", "reach_target", "--out", str(tmp_path / "x.json"))
    assert main(("evaluate", f"{tmp_path}/mine.py:make", *words)) == 1
    first, *more = capsys.readouterr().err.splitlines()
    assert first == "rlbench-pin: The policy crashed: RuntimeError: no weights: nowhere (mine.py, line 2)"
    assert not any("references.py" in line or "policy_server.py" in line for line in more)
