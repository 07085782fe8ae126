"""Task names may be typed with spaces or with commas between them."""

from __future__ import annotations

from pathlib import Path

import pytest

from rlbench_pin.cli.list_tasks import named_tasks, split_names
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
