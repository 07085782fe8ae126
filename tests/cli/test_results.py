"""`rlbench-pin results` prints tables, compares and draws; what it cannot use it refuses with the next step."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rlbench_pin.cli.main import main
from rlbench_pin.evaluation import write_results
from tests.evaluation.results.made import results

Captured = pytest.CaptureFixture[str]


@pytest.fixture
def files(tmp_path: Path) -> tuple[str, str]:
    """Return two results files of the same episodes."""
    first = results({"reach_target": "1" * 30, "open_drawer": "0" * 30}, "first")
    second = results({"reach_target": "1" * 30, "open_drawer": "1" * 30}, "second")
    return str(write_results(tmp_path / "a.json", first)), str(write_results(tmp_path / "b.json", second))


def test_tables(files: tuple[str, str], capsys: Captured) -> None:
    """One for each file, and all side by side."""
    assert main(["results", *files]) == 0
    text = capsys.readouterr().out
    assert text.startswith("first\n\ntask ") and "\n\nsecond\n\ntask " in text and "Success, with its 95 % interval" in text
    assert "compared" not in text and "30 episodes of a task give wide intervals" in text
    assert main(["results", files[0], "--markdown"]) == 0
    assert "| reach_target " in capsys.readouterr().out


def test_a_comparison_and_a_image(files: tuple[str, str], tmp_path: Path, capsys: Captured) -> None:
    """Of every further file with the first."""
    image = tmp_path / "new" / "plot.svg"
    assert main(["results", *files, "--compare", "--plot", str(image)]) == 0
    assert "'second' is better" in capsys.readouterr().out
    assert image.read_text().startswith("<?xml")


def test_json(files: tuple[str, str], capsys: Captured) -> None:
    """Everything that the tables have."""
    assert main(["results", *files, "--compare", "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert [entry["policy"] for entry in content["results"]] == ["first", "second"]
    assert content["results"][1]["mean"]["success"]["value"] == 1.0 and len(content["results"][0]["sha256"]) == 64
    (comparison,) = content["comparisons"]
    assert comparison["all"]["only_second"] == 30 and comparison["all"]["significant"] is True
    assert comparison["tasks"][0]["p_holm"] == 1.0 and comparison["difference"]["value"] == 0.5


def test_two_files_of_one_policy_are_told_apart(files: tuple[str, str], tmp_path: Path, capsys: Captured) -> None:
    """By the names of the files."""
    other = write_results(tmp_path / "later.json", results({"reach_target": "1" * 30, "open_drawer": "0" * 30}, "first"))
    assert main(["results", files[0], str(other)]) == 0
    assert "first (a)" in (text := capsys.readouterr().out) and "first (later)" in text


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        ([], 2, "No file was named"),
        (["a", "--compare"], 2, "needs two files"),
        (["a", "none.json"], 1, "there is no such file"),
        (["a", "--plot", "x.pdf"], 1, "has to end with .png or .svg"),
        (["a", "other", "--compare"], 1, "only the second has tasks open_box"),
        (["broken"], 1, "it was changed"),
    ],
)
def test_what_cannot_be_used(
    files: tuple[str, str], tmp_path: Path, capsys: Captured, words: list[str], code: int, says: str
) -> None:
    """Exit code 2 where the command was misused, 1 where a file cannot be used; nothing on stdout."""
    other = write_results(tmp_path / "other.json", results({"reach_target": "1" * 30, "open_box": "0" * 30}))
    broken = tmp_path / "broken.json"
    broken.write_text(Path(files[0]).read_text().replace("12.5", "13.5", 1))
    names = {"a": files[0], "other": str(other), "broken": str(broken)}
    assert main(["results", *(names.get(word, word) for word in words)]) == code
    captured = capsys.readouterr()
    assert says in captured.err and captured.out == ""


def test_a_comparison_can_be_forced(files: tuple[str, str], tmp_path: Path, capsys: Captured) -> None:
    """On what both have, and with other limits."""
    other = write_results(tmp_path / "c.json", results({"reach_target": "1" * 30}, "third", limits={"max_steps": 1}))
    assert main(["results", files[0], str(other), "--compare", "--common"]) == 1
    assert "--any-limits" in capsys.readouterr().err
    assert main(["results", files[0], str(other), "--compare", "--common", "--any-limits", "--stable"]) == 0
    assert "third compared with first: stable success" in (text := capsys.readouterr().out)
    assert "max_steps is 200 in the first and 1 in the second" in text
