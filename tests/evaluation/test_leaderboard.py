"""The leaderboard is what the results files say, and only files that can be compared and checked are on it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import write_leaderboard
from write_leaderboard import NotForThePage, checked, entries, page

from rlbench_pin.errors import InvalidValue, ResultsFileError
from rlbench_pin.evaluation import EpisodeRecord, Results, evaluation_seed, load_protocol, read_results, write_results
from tests.evaluation.protocols_for_tests import small_file

COMMIT = "0123456789abcdef0123456789abcdef01234567"


def made(folder: Path, policy: str, successes: int, **changes: Any) -> Results:
    """Return results by the small protocol with so many successes in each task."""
    protocol = load_protocol(small_file(folder))
    seeds = tuple(evaluation_seed(seed, i) for seed in (0, 10) for i in range(2))
    good = EpisodeRecord("reach_target", 0, seeds[0], success=True, lasts=True, steps=3, seconds=1.0, end="success")
    bad = replace(good, success=False, lasts=False, end="steps")
    episodes = tuple(
        replace(good if i < successes else bad, task=task, variation=variation, seed=seed)
        for task, variation in (("reach_target", 0), ("push_button", 4))
        for i, seed in enumerate(seeds)
    )
    tasks = ("reach_target", "push_button")
    plain = Results(policy, {}, "small", tasks, seeds, {}, {}, COMMIT, episodes, "key", protocol, (), "", dict.fromkeys(tasks, 1))
    return replace(plain, **changes)


def test_the_page_is_what_the_files_say() -> None:
    """Written again, it stays as it is; every submission is there, and the baselines that follow a protocol."""
    listed = entries()
    assert write_leaderboard.PAGE.read_text(encoding="utf-8") == page(listed), "run `python scripts/write_leaderboard.py`"
    assert {entry.results.policy.partition("?")[0] for entry in listed} >= {"noop", "random", "key_frames"}


def test_a_table_for_each_protocol_and_version_of_tasks(tmp_path: Path) -> None:
    """The best policy first; another version of a task begins another table."""
    later = made(tmp_path, "later", 4, task_versions={"reach_target": 1, "push_button": 2})
    for name, results in (("a", made(tmp_path, "worse", 1)), ("b", made(tmp_path, "better?x=1", 2)), ("c", later)):
        write_results(tmp_path / "in" / f"{name}.json", results)
    text = page(entries(tmp_path / "in", tmp_path / "none"))
    assert text.count("## small, version 1") == 2
    first, second = text.split("## small, version 1")[1:]
    assert first.index("`better` | 50.0 %") < first.index("`worse` | 25.0 %") and "1 for all tasks" in first
    assert "`push_button` 2, all others 1" in second and "| `later` | 100.0 %" in second and "[c.json](c.json)" in second


@pytest.mark.parametrize(
    ("changes", "error", "says"),
    [
        ({"protocol": None}, NotForThePage, "follows no protocol"),
        ({"factors": ("friction:1",)}, NotForThePage, "has factors"),
        ({"commit": f"{COMMIT} changed"}, NotForThePage, "without changes"),
        ({"commit": ""}, NotForThePage, "its commit is ''"),
        ({"episodes": ()}, InvalidValue, "lack episodes of the protocol"),
    ],
)
def test_a_file_that_does_not_belong_is_refused(
    tmp_path: Path, changes: dict[str, Any], error: type[Exception], says: str
) -> None:
    """With the reason and the next step."""
    with pytest.raises(error, match=says):
        checked(write_results(tmp_path / "a.json", made(tmp_path, "noop", 0, **changes)))


def test_changed_protocols_and_files_are_refused(tmp_path: Path) -> None:
    """Other content under the name of a published protocol, and an altered file."""
    published = load_protocol("peract18")
    protocol = replace(load_protocol(small_file(tmp_path)), name="peract18", version=published.version)
    path = write_results(tmp_path / "a.json", made(tmp_path, "noop", 0, protocol=protocol))
    with pytest.raises(NotForThePage, match="other content than the published one"):
        checked(path)
    assert read_results(path).protocol == protocol
    path.write_text(path.read_text().replace('"steps": 3', '"steps": 4', 1))
    with pytest.raises(ResultsFileError, match="it was changed"):
        checked(path)
