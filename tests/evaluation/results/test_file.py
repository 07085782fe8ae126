"""Equal results are equal files, to the byte; what a file says is believed only when everything in it fits together."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rlbench_pin.errors import InvalidValue, ResultsFileError, UnknownName
from rlbench_pin.evaluation.results.records import EpisodeRecord, Results, read_results, results_text, write_results
from tests.evaluation.results.made import episode, results


def test_what_is_written_is_read(tmp_path: Path) -> None:
    """Every field comes back, and the file is as long as it has episodes."""
    made = results({"reach_target": "1101", "open_drawer": "0f10"})
    path = write_results(tmp_path / "deep" / "a.json", made)
    assert read_results(path) == made
    assert read_results(str(path)).sha256 == made.sha256
    assert sum(line.startswith('{"task"') for line in path.read_text().splitlines()) == 8


def test_versions_of_tasks_are_written(tmp_path: Path) -> None:
    """In format 5, the task order aside; a file without them is read as one of versions 1, and written as before."""
    plain = results({"reach_target": "10", "open_drawer": "11"})
    made = replace(plain, task_versions={"reach_target": 2, "open_drawer": 1})
    path = write_results(tmp_path / "a.json", made)
    content = json.loads(path.read_text())
    assert (content["format"], content["task_versions"]) == (5, {"open_drawer": 1, "reach_target": 2})
    assert read_results(path) == made and read_results(path).version_of("reach_target") == 2
    assert results_text(made) == results_text(replace(plain, task_versions={"open_drawer": 1, "reach_target": 2}))
    old = read_results(write_results(tmp_path / "b.json", plain))
    assert old.content()["format"] == 1 and old.task_versions == {} and old.version_of("reach_target") == 1
    with pytest.raises(UnknownName, match="open_drawer"):
        old.version_of("open_drawr")
    for wrong in ({"reach_target": 1}, {"reach_target": 0, "open_drawer": 1}, {"reach_target": True, "open_drawer": 1}, [1]):
        with pytest.raises(InvalidValue, match="task_versions"):
            replace(plain, task_versions=wrong)  # type: ignore[arg-type]
    path.write_text(path.read_text().replace('"reach_target": 2', '"reach_target": 3'))
    with pytest.raises(ResultsFileError, match="it was changed"):
        read_results(path)


def test_equal_content_is_equal_to_the_byte() -> None:
    """Whatever the order of tables, and whether numbers are numpy's."""
    first = results({"reach_target": "10"})
    numbers = replace(
        first.episodes[0], seed=np.int64(first.seeds[0]), success=np.bool_(True), seconds=np.float64(first.episodes[0].seconds)
    )  # type: ignore[arg-type]
    again = replace(
        first,
        settings=dict(reversed(first.settings.items())),
        versions=dict(reversed(first.versions.items())),
        episodes=(numbers, *first.episodes[1:]),
    )
    assert results_text(first) == results_text(again)
    assert results_text(first) != results_text(results({"reach_target": "11"}))


@pytest.mark.parametrize(
    ("before", "after", "says"),
    [
        ('"format": 1', '"format": 6', "format 6, this package reads formats 1 to 5"),
        ('"format": 1', '"format": 5', "lacks .*task_versions"),
        ('"format": 1', '"format": 2', "lacks policy_seed_key"),
        ('"format": 1', '"format": true', "format True"),
        ('"steps": 10', '"steps": 11', "it was changed"),
        ('"steps": 10', '"steps": -1', r"steps has to be a whole number >= 0"),
        ('"steps": 10', '"steps": "ten"', r"Got 'ten'"),
        ('"steps": 10', '"steps": 1.5', r"Got 1.5"),
        ('"seconds": 0.5', '"seconds": NaN', "it contains NaN"),
        ('"seconds": 0.5', '"seconds": 1e999', "finite number"),
        ('"success": true', '"success": false', "contradicts its end"),
        ('"task": "reach_target"', '"task": "another"', "has to be of its tasks"),
        ('"steps": 10', '"stops": 10', "lacks steps"),
        ('"steps": 10', '"steps": 10, "more": 1', "has 'more', which is not part of this format"),
        ('"policy": "noop"', '"policy": ["noop"]', "has to be a text"),
        ('"sha256"', '"sha255"', "lacks sha256"),
        ('"settings": {', '"settings": [], "x": {', "is not part of this format"),
        ('"commit": ""', '"commit": "1"', "it was changed"),
        ('"episodes": [', '"episodes": [1, ', "an episode is 1, not a table"),
        ('{"task"', '[' * 3000 + '{"task"', "nested too deeply|Expecting"),
    ],
)  # fmt: skip
def test_hostile_files_are_refused(tmp_path: Path, before: str, after: str, says: str) -> None:
    """Each with what is wrong, and the next step."""
    text = results_text(results({"reach_target": "1"}))
    assert before in text
    path = tmp_path / "a.json"
    path.write_text(text.replace(before, after, 1))
    with pytest.raises(ResultsFileError, match=says) as raised:
        read_results(path)
    assert str(path) in str(raised.value) and "rlbench-pin evaluate" in str(raised.value)
    assert raised.value.path == path


@pytest.mark.parametrize("content", [b"", b"[]", b"1", b"\xff\xfe\x00", b"null", b'{"format": 1' + b"0" * 5000 + b"}", b"{}"])
def test_what_is_no_results_file_is_refused(tmp_path: Path, content: bytes) -> None:
    """Whatever the bytes are."""
    path = tmp_path / "a.json"
    path.write_bytes(content)
    with pytest.raises(ResultsFileError):
        read_results(path)
    with pytest.raises(ResultsFileError, match="there is no such file"):
        read_results(tmp_path / "none.json")
    with pytest.raises(ResultsFileError, match="there is no such file"):
        read_results(tmp_path)


def test_a_huge_file_is_not_read(tmp_path: Path) -> None:
    """It is refused by its size."""
    with open(tmp_path / "a.json", "wb") as file:
        file.truncate(1 << 40)
    with pytest.raises(ResultsFileError, match="more than"):
        read_results(tmp_path / "a.json")


@pytest.mark.parametrize(
    "change",
    [
        {"steps": -1}, {"seconds": float("inf")}, {"success": "yes"}, {"end": "won"},
        {"lasts": True, "success": False, "end": "steps"},
        {"fault": "crashed"}, {"refused": {"a": -1}}, {"refused": [1]}, {"violations": {1: 1}}, {"task": ""}, {"seed": -1},
        {"max_force": float("nan")}, {"fault_detail": "x" * 20_000}, {"variation": True},
    ],
)  # fmt: skip
def test_records_are_checked_when_they_are_made(change: dict[str, Any]) -> None:
    """Not only when they are read."""
    with pytest.raises(InvalidValue):
        replace(episode("reach_target", 0, "1"), **change)


def test_results_hold_each_episode_once_in_order() -> None:
    """Of their tasks and seeds; settings are plain data."""
    made = results({"reach_target": "10", "open_drawer": "11"})
    first, second, third, fourth = made.episodes
    wrong: list[dict[str, Any]] = [
        {"episodes": (first, first, third, fourth)}, {"episodes": (third, fourth, first, second)}, {"tasks": ("reach_target",)},
        {"seeds": made.seeds[:1]}, {"seeds": made.seeds * 2}, {"settings": {"a": float("nan")}}, {"settings": {"a": object()}},
        {"settings": {"a": np.zeros(3)}}, {"limits": {"a": [1]}}, {"tasks": "reach_target"}, {"episodes": (1,)},
        {"versions": {"a": 1}},
    ]  # fmt: skip
    for change in wrong:
        with pytest.raises(InvalidValue):
            replace(made, **change)
    deep: list[Any] = []
    for _ in range(50):
        deep = [deep]
    with pytest.raises(InvalidValue, match="levels"):
        replace(made, settings={"a": deep})


def test_the_checksum_covers_everything() -> None:
    """Any other content has another one, and the text holds it."""
    made = results({"reach_target": "10"})
    others = [
        replace(made, policy="random"), replace(made, commit="1"),
        replace(made, limits={"max_steps": 1}), replace(made, task_set="x"),
        replace(made, seeds=(*made.seeds, 7)), replace(made, episodes=made.episodes[:1]),
        replace(made, task_versions={"reach_target": 1}), replace(made, task_versions={"reach_target": 2}),
    ]  # fmt: skip
    assert len({made.sha256, *(other.sha256 for other in others)}) == 9
    assert json.loads(results_text(made))["sha256"] == made.sha256


def test_no_episode_is_no_crash(tmp_path: Path) -> None:
    """An evaluation that ended before its first episode still has a file."""
    empty = Results("noop", {}, "reach_target", ("reach_target",), (0,), {}, {}, "", ())
    assert read_results(write_results(tmp_path / "a.json", empty)) == empty
    assert isinstance(episode("reach_target", 0, "1"), EpisodeRecord)
