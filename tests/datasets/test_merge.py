"""Merging keeps every episode, gives numbers once, and refuses what does not go together."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from rlbench_pin.datasets import (
    DatasetWriter,
    episode_files,
    read_manifest,
    task_faults,
)
from rlbench_pin.datasets.merge import Move, merge_datasets
from rlbench_pin.datasets.storage import hold
from rlbench_pin.errors import DatasetConflict, DatasetError, EpisodeFileError
from tests.demos_for_tests import fill, make_demo

TASK = "reach_target"


@pytest.mark.simulation
def test_merging_keeps_every_episode(tmp_path: Path) -> None:
    """The result holds the same bytes under numbers of its own; merging again, or what is there already, adds nothing."""
    one, two = fill(tmp_path / "one", range(3)), fill(tmp_path / "two", range(2, 6))
    fill(two, range(2), variation=4)
    out = tmp_path / "out"
    assert len(merge_datasets([one, two], out)) == 8
    entries = read_manifest(out, TASK)
    assert [(e.variation, e.episode, e.random_seed) for e in entries] == [
        *((0, n, n) for n in range(6)), (4, 0, 0), (4, 1, 1),
    ]  # fmt: skip
    assert task_faults(out, TASK) == []
    assert merge_datasets([two, one], out) == ()
    assert read_manifest(out, TASK) == entries


def test_merging_into_a_folder_in_use_is_refused(tmp_path: Path) -> None:
    """While a recording holds the result nothing is merged, and the other way round: both would give the same numbers."""
    one, out = fill(tmp_path / "one", range(2)), fill(tmp_path / "out", range(5, 6))
    with hold(out), pytest.raises(DatasetConflict, match=r"into '.*out' is running\. Wait for it"):
        merge_datasets([one], out)
    assert len(read_manifest(out, TASK)) == len(episode_files(out, TASK)) == 1

    def hold_too(_: Move) -> None:
        with pytest.raises(DatasetConflict, match="is running"), hold(out):
            pass

    assert len(merge_datasets([one], out, hold_too)) == 2
    with hold(out):
        assert merge_datasets([one], out) == ()  # there is nothing to write


def test_merging_counts_on_from_a_recording_that_has_just_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Episodes that were stored after the first look at the result keep their numbers."""
    one, out = fill(tmp_path / "one", range(2)), fill(tmp_path / "out", range(5, 6))

    @contextmanager
    def hold_late(root: Path) -> Iterator[None]:
        fill(root, range(7, 8))
        with hold(root):
            yield

    monkeypatch.setattr("rlbench_pin.datasets.merge.hold", hold_late)
    merge_datasets([one], out)
    assert [entry.random_seed for entry in read_manifest(out, TASK)] == [5, 7, 0, 1]
    assert task_faults(out, TASK) == []


def test_merging_refuses_what_does_not_go_together(tmp_path: Path) -> None:
    """The same seed with other content, other images, or a bad file: an error, and nothing is written."""
    one, two = fill(tmp_path / "one", range(3)), fill(tmp_path / "two", range(2, 5), frames=3)
    with pytest.raises(DatasetConflict, match=r"episode0\.h5.*seed 2, but differ"):
        merge_datasets([one, two], tmp_path / "out")
    later = make_demo(frames=2, seed=8)
    later.task_version = 2
    DatasetWriter(tmp_path / "later").add(later)
    with pytest.raises(
        DatasetConflict, match=r"'reach_target' has different versions: version 1 in .*one', version 2 in .*later'"
    ):
        merge_datasets([one, tmp_path / "later"], tmp_path / "out")
    plain = make_demo(frames=2, seed=9)
    for observation in plain:
        observation.front_mask = None
    DatasetWriter(tmp_path / "three").add(plain)
    with pytest.raises(DatasetConflict, match="rerender"):
        merge_datasets([one, tmp_path / "three"], tmp_path / "out")
    assert not (tmp_path / "out").exists()
    episode_files(one, TASK)[1].write_bytes(b"not it")
    with pytest.raises(EpisodeFileError, match=r"episode1\.h5.*SHA-256"):
        merge_datasets([one], tmp_path / "out")
    with pytest.raises(DatasetError, match="does not exist"):
        merge_datasets([tmp_path / "nowhere"], tmp_path / "out")


def test_episodes_without_a_seed_are_known_by_their_bytes(tmp_path: Path) -> None:
    """Two different ones are both kept; one that is there already is not copied."""
    for folder, numbers in (("one", (1, 2)), ("two", (2, 3))):
        for number in numbers:
            demo = make_demo(frames=2, seed=number)
            demo.random_seed = None
            DatasetWriter(tmp_path / folder).add(demo)
    out = tmp_path / "out"
    assert len(merge_datasets([tmp_path / "one", tmp_path / "two"], out)) == 3
    assert len(read_manifest(out, TASK)) == 3
