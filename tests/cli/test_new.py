"""A pair of files made by `new` is a task at once, outside the package."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from rlbench_pin.cli.main import main

CONTRIBUTING = Path(__file__).resolve().parents[2] / "CONTRIBUTING.md"


def test_a_new_task_passes_check_and_can_be_drawn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Without touching the package: checked, and shown."""
    assert main(["new", "touch_it", "--out", str(tmp_path)]) == 0
    file = tmp_path / "touch_it.py"
    assert str(file) in capsys.readouterr().out
    assert main(["check", "--task-file", str(file), "--episodes", "6", "--no-contract"]) == 0
    assert "touch_it" in capsys.readouterr().out
    assert main(["view", str(file), "--out", str(tmp_path / "touch_it.png")]) == 0
    assert (tmp_path / "touch_it.png").stat().st_size > 10_000


@pytest.mark.slow
def test_a_new_task_keeps_the_whole_contract(tmp_path: Path) -> None:
    """Resting and flailing solve nothing, resets repeat, demonstrations succeed."""
    main(["new", "touch_it", "--out", str(tmp_path)])
    assert main(["check", "--task-file", str(tmp_path / "touch_it.py"), "--episodes", "20"]) == 0


def test_an_edited_pair_becomes_another_task(tmp_path: Path) -> None:
    """The scene and the class of the walk-through in CONTRIBUTING.md, put in the place of what `new` wrote."""
    main(["new", "put_cube_on_square", "--out", str(tmp_path / "mine")])
    for language in ("toml", "python"):
        _write_files(language, tmp_path)
    file = tmp_path / "mine" / "put_cube_on_square.py"
    assert main(["check", "--task-file", str(file), "--episodes", "4", "--no-contract"]) == 0


@pytest.mark.slow
def test_the_walk_through_works_as_it_stands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every command and every file of CONTRIBUTING.md, in their order, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    steps = re.findall(r"```(bash|toml|python)\n(.*?)```", _walk_through(), re.DOTALL)
    assert [language for language, _ in steps] == ["bash", "toml", "python", "bash"]
    for language, text in steps:
        if language != "bash":
            _write_files(language, tmp_path)
            continue
        for line in text.splitlines():
            program, *arguments = shlex.split(line)
            assert program == "rlbench-pin"
            assert main(arguments) == 0, line
    assert "ok" in (tmp_path / "out" / "put_cube_on_square" / "report.md").read_text()
    assert list((tmp_path / "out" / "demo").rglob("*.h5"))


def _walk_through() -> str:
    text = CONTRIBUTING.read_text(encoding="utf-8")
    start = text.index("## From a reach to a pick-and-place")
    return text[start : text.index("\n## ", start)]


def _write_files(language: str, folder: Path) -> None:
    """Write each block of a language to the file that its first line names, over what `new` wrote."""
    for name, text in re.findall(rf"```{language}\n# (\S+)\n(.*?)```", _walk_through(), re.DOTALL):
        assert (folder / name).is_file()
        (folder / name).write_text(text, encoding="utf-8")


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("Touch It", "not a valid task name"),
        ("touch\n", "not a valid task name"),
        ("reach_target", "exists already"),
        ("import", "keyword of Python"),
        ("true", "keyword of Python"),
        ("spawn_boundary", "would hide rlbench_pin.tasks.SpawnBoundary"),
    ],
)
def test_bad_names_are_refused(name: str, says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Misuse is exit code 2, and nothing is written."""
    assert main(["new", name, "--out", str(tmp_path)]) == 2
    assert says in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_existing_files_are_not_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A second `new` of the same name is refused."""
    assert main(["new", "touch_it", "--out", str(tmp_path)]) == 0
    before = (tmp_path / "touch_it.py").read_text()
    assert main(["new", "touch_it", "--out", str(tmp_path)]) == 2
    assert "would be overwritten" in capsys.readouterr().err
    assert (tmp_path / "touch_it.py").read_text() == before
