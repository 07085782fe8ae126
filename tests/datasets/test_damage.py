"""Files that are damaged, missing, unlisted or of another format: found, named, and never served."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest

from rlbench_pin.datasets import (
    DatasetWriter,
    encode_demo,
    episode_entry,
    episode_files,
    episode_path,
    read_demo,
    stored_demos,
    task_faults,
    write_demo,
)
from rlbench_pin.environment.stored import read_stored_descriptions
from rlbench_pin.errors import DatasetError, EpisodeFileError
from tests.demos_for_tests import edit_manifest, make_demo

TASK = "reach_target"


@pytest.mark.parametrize("where", [0.02, 0.3, 0.6, 0.97])
def test_a_flipped_bit_is_found_and_named(root: Path, where: float) -> None:
    """`verify` finds it and `stored_demos` refuses it, wherever in the file it is; the others are still served."""
    path = episode_files(root, TASK)[2]
    data = bytearray(path.read_bytes())
    data[int(where * len(data))] ^= 0b100
    path.write_bytes(bytes(data))
    (fault,) = task_faults(root, TASK)
    assert isinstance(fault, EpisodeFileError)
    assert fault.path == path
    with pytest.raises(EpisodeFileError, match=r"episode2\.h5.*SHA-256"):
        stored_demos(root, TASK, -1, 0, random_selection=False)
    assert len(stored_demos(root, TASK, 2, 0, random_selection=False)) == 2


def test_a_truncated_file_is_found_and_named(root: Path) -> None:
    """So is a file that was cut off, together with every other fault of the task."""
    files = episode_files(root, TASK)
    os.truncate(files[1], files[1].stat().st_size // 2)
    files[3].unlink()
    faults = task_faults(root, TASK)
    assert [fault.path for fault in faults if isinstance(fault, EpisodeFileError)] == [files[1], files[3]]
    with pytest.raises(EpisodeFileError, match=r"episode1\.h5"):
        stored_demos(root, TASK, -1, 0, random_selection=False)


def test_a_file_that_is_not_what_its_entry_says_is_found(root: Path) -> None:
    """A manifest with a wrong seed or length is found by reading the file, and only then."""
    edit_manifest(root, random_seed=99)
    assert task_faults(root, TASK, structure=False) == []
    (fault,) = task_faults(root, TASK)
    assert "99" in str(fault)
    assert "episode1.h5" in str(fault)


def test_a_later_format_is_named(root: Path) -> None:
    """An episode of another format version is refused with both versions."""
    path = episode_files(root, TASK)[0]
    (root / TASK / "manifest.json").unlink()  # otherwise the SHA-256 says that it was altered
    with h5py.File(path, "a") as file:
        file.attrs["version"] = 2
    with pytest.raises(EpisodeFileError, match=r"episode0\.h5.*version 2.*version 1.*record it again"):
        read_demo(path)


def test_a_file_that_is_not_listed_does_not_count(root: Path) -> None:
    """Whole or not, it is served neither in order nor at random, nor is a variation of such files."""
    files = episode_files(root, TASK)
    shutil.copy(files[0], files[0].with_name("episode4.h5"))
    files[0].with_name("episode5.h5").write_bytes(b"half an episode")
    (root / TASK / "variation7" / "episodes").mkdir(parents=True)
    shutil.copy(files[0], root / TASK / "variation7" / "episodes" / "episode0.h5")
    for variation in (0, -1):
        demos = stored_demos(root, TASK, -1, variation, random_selection=False)
        assert [demo.random_seed for demo in demos] == [0, 1, 2, 3]
    drawn = stored_demos(root, TASK, 4, -1, rng=np.random.default_rng(0))
    assert sorted(str(demo.random_seed) for demo in drawn) == ["0", "1", "2", "3"]
    with pytest.raises(DatasetError, match=r"5 demos.*has 4"):
        stored_demos(root, TASK, 5, 0, random_selection=False)
    with pytest.raises(DatasetError, match=r"no variation 7 .*Choose one of \[0\]"):
        stored_demos(root, TASK, 1, 7, random_selection=False)
    with pytest.raises(DatasetError, match="contains 4 episodes"):
        read_stored_descriptions(str(root), TASK, 4)


def test_a_listed_file_that_is_missing_is_named(root: Path) -> None:
    """It is not skipped, so that nobody trains on fewer demonstrations than were asked for; the others are still served."""
    path = episode_files(root, TASK)[1]
    path.unlink()
    words = r"episode1\.h5' is listed.*`rlbench-pin dataset verify`.*`rlbench-pin record --resume`"
    with pytest.raises(EpisodeFileError, match=words) as caught:
        stored_demos(root, TASK, -1, 0, random_selection=False)
    assert caught.value.path == path
    with pytest.raises(EpisodeFileError, match=words):
        stored_demos(root, TASK, -1, -1, image_paths=True, rng=np.random.default_rng(0))
    with pytest.raises(EpisodeFileError, match=words):
        read_stored_descriptions(str(root), TASK, 1)
    demos = stored_demos(root, TASK, 2, 0, random_selection=False, from_episode_number=2)
    assert [demo.random_seed for demo in demos] == [2, 3]
    assert read_stored_descriptions(str(root), TASK, 2) == ["reach the red ball", "touch the ball that is red"]


def test_without_a_manifest_every_episode_file_counts(tmp_path: Path) -> None:
    """`write_demo` alone makes a folder that can be read; with the first line of a manifest, only what is listed counts."""
    demos = [make_demo(frames=2, seed=seed) for seed in range(3)]
    for number, demo in enumerate(demos[:2]):
        write_demo(demo, episode_path(tmp_path, TASK, 0, number))
    assert [d.random_seed for d in stored_demos(tmp_path, TASK, -1, 0, random_selection=False)] == [0, 1]
    assert len(read_stored_descriptions(str(tmp_path), TASK, 1)) == 2
    data = encode_demo(demos[2])
    DatasetWriter(tmp_path).put(TASK, data, episode_entry(demos[2], data, 2))
    assert [d.random_seed for d in stored_demos(tmp_path, TASK, -1, 0, random_selection=False)] == [2]
