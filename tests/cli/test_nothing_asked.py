"""A command that would do nothing, or less than it says, is misused: exit code 2, a line that says how it is used, no file."""

from __future__ import annotations

from pathlib import Path

import pytest

from rlbench_pin import Discrete, Environment, JointVelocity, MoveArmThenGripper
from rlbench_pin.datasets import DatasetWriter
from rlbench_pin.datasets.layout import manifest_path
from rlbench_pin.errors import TaskEnvironmentError
from tests.cli.support import TASK, exit_code
from tests.demos_for_tests import make_demo

Capture = pytest.CaptureFixture[str]

NOTHING = [
    (("replay",), "No episode was named. Use `rlbench-pin replay FILE...`"),
    (("video",), "No task was named. Use `rlbench-pin video TASK...`"),
    (("video", ","), "No task was named"),
    (("problems", "export"), "No task was named. Use `rlbench-pin problems export TASK...`"),
    (("problems", "export", ", ,"), "No task was named"),
    (("check", ","), "No task was named"),
    (("record", ","), "No task was named"),
    (("evaluate",), "No policy was named"),
    (("evaluate", "expert", "--tasks", ","), "No task was named"),
    (("conventions",), "No policy was named. Use `rlbench-pin conventions POLICY`"),
    (("challenge", "run"), "No learner was named. Use `rlbench-pin challenge run LEARNER`"),
    (("dataset", "merge"), "No dataset was named"),
    (("dataset", "export", "robomimic", ".", "out", "--tasks", ","), "No task was named"),
    (("dataset", "rerender", ".", "--tasks", ","), "No task was named"),
]

NUMBERS = [
    ("demo", TASK, "--episodes", "0"),
    ("demo", TASK, "--episodes", "-3"),
    ("demo", TASK, "--max-attempts", "0"),
    ("demo", TASK, "--image-size", "0", "64"),
    ("demo", TASK, "--seed", "-1"),
    ("demo", TASK, "--variation", "-2"),
    ("challenge", "run", "nearest", "--shots", "0"),
    ("challenge", "run", "nearest", "--episodes", "0"),
    ("check", TASK, "--contract-seeds", "-1"),
    ("check", TASK, "--contract-seeds", "0"),
    ("check", TASK, "--placements", "0"),
    ("check", TASK, "--episodes", "0"),
    ("check", TASK, "--replays", "-1"),
    ("check", TASK, "--workers", "0"),
    ("check", TASK, "--seed", "-1"),
    ("video", TASK, "--max-attempts", "0"),
    ("video", TASK, "--fps", "0"),
    ("video", TASK, "--size", "0", "0"),
    ("video", TASK, "--seed", "-1"),
    ("view", TASK, "--size", "0"),
    ("view", TASK, "--seed", "-1"),
    ("problems", "export", TASK, "--episodes", "0"),
    ("record", TASK, "--workers", "-1"),
]


@pytest.mark.parametrize(("words", "says"), NOTHING)
def test_nothing_to_work_on(
    words: tuple[str, ...], says: str, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No task, no file, no folder: commas alone are nothing, too."""
    monkeypatch.chdir(tmp_path)
    more = ("--out", "out") if words[-1] != "evaluate" and words[:2] in (("dataset", "merge"), ("dataset", "rerender")) else ()
    assert exit_code(*words, *more) == 2
    out, err = capsys.readouterr()
    assert says in err
    assert out == ""
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("words", NUMBERS, ids=" ".join)
def test_numbers_that_ask_for_nothing(
    words: tuple[str, ...], tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The option, its value and the least that makes sense."""
    monkeypatch.chdir(tmp_path)
    (option,) = [word for word in words if word.startswith("--")]
    assert exit_code(*words) == 2
    assert f"{option} is {' '.join(words[words.index(option) + 1 :])}; it must be at least " in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_videos_that_cannot_be(tmp_path: Path, capsys: Capture) -> None:
    """An odd size, a speed that is no number; a misspelt task is found before the first video."""
    for words, says in (
        (("--size", "33", "48"), "even width and height"),
        (("--speed", "nan"), "--speed is nan"),
        (("push_buton",), "Did you mean 'push_button'"),
    ):
        assert exit_code("video", TASK, *words, "--out", str(tmp_path / "videos")) == 2
        assert says in capsys.readouterr().err
        assert not (tmp_path / "videos").exists()


def test_a_image_of_no_known_kind(tmp_path: Path, capsys: Capture) -> None:
    """The ends of names that are possible."""
    assert exit_code("view", TASK, "--out", str(tmp_path / "image.xyz")) == 2
    assert ".png, .jpg, .jpeg" in capsys.readouterr().err


def test_datasets_without_episodes(tmp_path: Path, capsys: Capture) -> None:
    """A manifest that lists nothing is not replayed, merged, exported or listed as if all were well."""
    DatasetWriter(tmp_path / "data").add(make_demo(frames=3, seed=0))
    (task,) = [folder.name for folder in (tmp_path / "data").iterdir() if folder.is_dir()]
    file = next((tmp_path / "data").rglob("*.h5"))
    for damage in ("empty", "gone"):
        if damage == "empty":
            file.unlink()
            text = manifest_path(tmp_path / "data", task).read_text()
            manifest_path(tmp_path / "data", task).write_text(text[: text.index('"episodes"')] + '"episodes": []\n}\n')
        else:
            manifest_path(tmp_path / "data", task).unlink()
        for words in (
            ("replay", "DATA"),
            ("dataset", "info", "DATA"),
            ("dataset", "verify", "DATA"),
            ("dataset", "merge", "DATA", "--out", "OUT"),
            ("dataset", "seeds", "DATA", "OUT"),
            ("dataset", "export", "robomimic", "DATA", "OUT"),
            ("dataset", "rerender", "DATA", "--out", "OUT"),
        ):
            places = {"DATA": str(tmp_path / "data"), "OUT": str(tmp_path / "out")}
            assert exit_code(*(places.get(word, word) for word in words)) == 1, (damage, words)
            assert "rlbench-pin:" in capsys.readouterr().err


def test_merging_what_is_not_there(tmp_path: Path, capsys: Capture) -> None:
    """One folder without demonstrations among the others is an error."""
    (tmp_path / "empty").mkdir()
    DatasetWriter(tmp_path / "data").add(make_demo(frames=3, seed=0))
    assert exit_code("dataset", "merge", str(tmp_path / "data"), str(tmp_path / "empty"), "--out", str(tmp_path / "out")) == 1
    assert "contains no demonstrations" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_legs_that_are_no_problems_are_counted(tmp_path: Path, capsys: Capture) -> None:
    """`problems export` says what it leaves out; files and counts agree."""
    assert exit_code("problems", "export", "take_lid_off_saucepan", "--episodes", "1", "--out", str(tmp_path)) == 0
    line = capsys.readouterr().out.strip()
    files = list(tmp_path.glob("*.json"))
    assert line.startswith(f"take_lid_off_saucepan: {len(files)} problems in {tmp_path}; left out: ")
    assert "that ignore collisions" in line
    assert sorted(tmp_path.iterdir()) == sorted(files)


def test_no_tries_is_an_error_in_programs_too() -> None:
    """Not a demonstration that failed 0 times."""
    with Environment(MoveArmThenGripper(JointVelocity(), Discrete())) as environment:
        task = environment.get_task(TASK)
        with pytest.raises(TaskEnvironmentError, match="max_attempts has to be a whole number"):
            task.get_demos(1, live_demos=True, max_attempts=0)
