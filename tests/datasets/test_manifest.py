"""The manifest and its journal: every episode that counts, also after a crash."""

from __future__ import annotations

import json
import os
from dataclasses import asdict, replace
from pathlib import Path

import pytest

from rlbench_pin.datasets import (
    DatasetWriter,
    encode_demo,
    episode_entry,
    fold_journal,
    read_manifest,
    verify_task,
)
from rlbench_pin.datasets.manifest import append_entry
from rlbench_pin.errors import DatasetError, EpisodeFileError
from tests.demos_for_tests import fill, make_demo

TASK = "reach_target"


def test_a_folder_that_is_no_dataset_is_an_error(tmp_path: Path) -> None:
    """No folder, an empty one, one of another task, a folder that only has the name: none reads as an empty dataset."""
    with pytest.raises(DatasetError, match=r"nowhere.*does not exist"):
        read_manifest(tmp_path / "nowhere", TASK)
    with pytest.raises(DatasetError, match=f"{TASK}"):
        read_manifest(tmp_path, TASK)
    fill(tmp_path, range(1))
    with pytest.raises(DatasetError, match="reach_targt"):
        read_manifest(tmp_path, "reach_targt")
    (tmp_path / "push_button").mkdir()
    with pytest.raises(EpisodeFileError, match=r"not a dataset with episodes of 'push_button'.*rlbench-pin record push_button"):
        read_manifest(tmp_path, "push_button")
    assert len(read_manifest(tmp_path, TASK)) == 1


def test_the_journal_is_part_of_the_manifest(tmp_path: Path) -> None:
    """Episodes count as soon as they are noted; folding the journal changes only where they are listed."""
    for seed in range(3):
        demo = make_demo(frames=2, seed=seed)
        data = encode_demo(demo)
        DatasetWriter(tmp_path).put(TASK, data, episode_entry(demo, data, seed, ["no path: wall"] if seed == 1 else []))
    before = read_manifest(tmp_path, TASK)
    assert [entry.failures for entry in before] == [[], ["no path: wall"], []]
    assert not (tmp_path / TASK / "manifest.json").exists()
    verify_task(tmp_path, TASK, structure=True)
    fold_journal(tmp_path, TASK)
    assert read_manifest(tmp_path, TASK) == before
    assert not list((tmp_path / TASK).glob(".*journal"))


@pytest.mark.parametrize("cut", [1, 20, 200])
def test_a_line_that_was_cut_off_never_counted(tmp_path: Path, cut: int) -> None:
    """After a crash in the middle of a line, the lines before it count, and further ones are added behind them."""
    demo = make_demo(frames=2)
    entries = [episode_entry(demo, b"", number) for number in range(4)]
    for entry in entries[:3]:
        append_entry(tmp_path, TASK, entry)
    journal = tmp_path / TASK / ".manifest.journal"
    os.truncate(journal, journal.stat().st_size - cut)
    assert read_manifest(tmp_path, TASK) == tuple(entries[:2])
    append_entry(tmp_path, TASK, entries[3])
    assert read_manifest(tmp_path, TASK) == (*entries[:2], entries[3])


def test_entries_are_plain(root: Path) -> None:
    """An entry is JSON and back."""
    for entry in read_manifest(root, TASK):
        assert type(entry)(**json.loads(json.dumps(asdict(entry)))) == entry
        assert replace(entry, failures=["x"]).failures == ["x"]
