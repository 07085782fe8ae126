"""Task names may be typed with spaces or with commas between them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rlbench_pin.cli.list_tasks import named_tasks, split_names
from rlbench_pin.cli.main import main
from rlbench_pin.evaluation import task_set, task_sets
from rlbench_pin.tasks import task_names


@pytest.mark.parametrize(
    "words", [("a", "b", "c"), ("a,b", "c"), ("a,b,c",), ("a,", "b", ",c"), ("a, b ,c",), ("a,b", "b", "c,a")]
)
def test_commas_are_as_good_as_spaces(words: tuple[str, ...]) -> None:
    """In any mixture; each name counts once, in order."""
    assert split_names(words) == ("a", "b", "c")


def test_nothing_is_named() -> None:
    """No words, or commas alone."""
    assert split_names(()) == split_names((",", " ")) == named_tasks(()) == ()


def test_all_stands_for_every_task() -> None:
    """Alone or among others; a list of all of them, longer than any file name may be, is the same."""
    assert named_tasks(("all",)) == named_tasks((",".join(task_names()),)) == task_names()
    assert named_tasks(("my.py,all", task_names()[0])) == ("my.py", *task_names())
    assert split_names(("all",)) == ("all",)


def test_files_may_have_commas(tmp_path: Path) -> None:
    """A path that exists stays whole."""
    file = tmp_path / "one,two.py"
    assert split_names((str(file),)) == (str(tmp_path / "one"), "two.py")
    file.touch()
    assert split_names((str(file), "a,b")) == (str(file), "a", "b")


def test_sets_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    """A line each, with how many tasks it has; as JSON with their names."""
    assert main(["list", "--sets"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[:-1]] == list(task_sets())
    first = task_set("FS10_V1")
    assert lines[0].split()[1] == "15"
    assert main(["list", "--sets", "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["FS10_V1"]["parts"]["test"] == list(first.parts["test"])
    assert len(content["MT100_V1"]["tasks"]) == 100


def listed(capsys: pytest.CaptureFixture[str], *words: str) -> list[str]:
    """Return the names that `list` prints."""
    assert main(["list", *words]) == 0
    return [line.split()[0] for line in capsys.readouterr().out.splitlines()]


def test_lists_are_filtered(capsys: pytest.CaptureFixture[str]) -> None:
    """By words of names and descriptions, tier, set and family, all of which have to fit."""
    assert listed(capsys, "drawer", "cube") == ["put_item_in_drawer", "take_item_out_of_drawer"]
    assert set(listed(capsys, "--tier", "1")) <= set(task_set("tier1").tasks)
    assert listed(capsys, "--family", "doors", "--tier", "1", "microwave") == ["close_microwave"]
    assert set(listed(capsys, "--set", "FS10_V1:test")) == set(task_set("FS10_V1:test").tasks)
    assert main(["list", "no such thing"]) == 0
    assert "No task matches. Leave out a word" in capsys.readouterr().err
    assert main(["list", "peract18"]) == 0
    assert "Use `--set PERACT18`" in capsys.readouterr().err
    for words, hint in ((["--tier", "7"], "tier"), (["--family", "door"], "doors"), (["--set", "FS10"], "FS10_V1")):
        assert main(["list", *words]) == 2
        assert hint in capsys.readouterr().err
