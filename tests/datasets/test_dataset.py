"""A dataset folder: episodes are stored, numbered, listed with their checksum, and found again."""

from __future__ import annotations

import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.datasets import (
    DatasetWriter,
    episode_files,
    episode_path,
    read_demo,
    read_image,
    read_manifest,
    stored_demos,
    stored_variations,
    verify_task,
    write_demo,
)
from rlbench_pin.errors import DatasetError
from tests.demos_for_tests import assert_equal, make_demo

TASK = "reach_target"


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """A dataset of twelve episodes of variation 0 and one of variation 2."""
    writer = DatasetWriter(tmp_path, compression="lzf")
    for seed in range(12):
        writer.add(make_demo(frames=2, seed=seed))
    writer.add(make_demo(frames=2, seed=0, variation=2))
    return tmp_path


def test_layout(root: Path) -> None:
    """Episodes lie in `<root>/<task>/variation<k>/episodes/episode<j>.h5`, and nothing is left beside them."""
    assert stored_variations(root, TASK) == (0, 2)
    folder = root / TASK / "variation0" / "episodes"
    assert [p.name for p in episode_files(root, TASK, 0)] == [f"episode{i}.h5" for i in range(12)]
    assert sorted(p.name for p in folder.iterdir()) == sorted(f"episode{i}.h5" for i in range(12))


def test_manifest_lists_every_episode(root: Path) -> None:
    """Each entry has seed, frames, size and SHA-256."""
    entries = read_manifest(root, TASK)
    assert [e.random_seed for e in entries if e.variation == 0] == list(range(12))
    assert {e.frames for e in entries} == {2}
    assert all(len(e.sha256) == 64 for e in entries)
    verify_task(root, TASK)


def test_writing_the_same_demo_again_replaces_it(root: Path) -> None:
    """A command that is run twice leaves the same dataset."""
    before = (root / TASK / "manifest.json").read_bytes()
    path = DatasetWriter(root, compression="lzf").add(make_demo(frames=2, seed=4))
    assert path.name == "episode4.h5"
    assert (root / TASK / "manifest.json").read_bytes() == before


def test_several_writers_share_a_folder(tmp_path: Path) -> None:
    """Episodes written at the same time get different numbers and are all listed."""
    with ThreadPoolExecutor(4) as pool:
        paths = list(pool.map(lambda seed: DatasetWriter(tmp_path).add(make_demo(frames=2, seed=seed)), range(8)))
    assert len(set(paths)) == 8
    assert len(read_manifest(tmp_path, TASK)) == 8
    verify_task(tmp_path, TASK)


def test_load_in_order(root: Path) -> None:
    """Without a generator, episodes come in natural order from a first one."""
    demos = stored_demos(root, TASK, 3, 0, random_selection=False, from_episode_number=9)
    assert [d.random_seed for d in demos] == [9, 10, 11]


def test_gaps_in_the_numbers_do_not_count(tmp_path: Path) -> None:
    """The first episode is an index of what is there, whatever the files are called."""
    for number in (2, 10, 30):
        write_demo(make_demo(frames=2, seed=number), episode_path(tmp_path, TASK, 0, number))
    demos = stored_demos(tmp_path, TASK, -1, 0, random_selection=False, from_episode_number=1)
    assert [d.random_seed for d in demos] == [10, 30]


def test_load_at_random(root: Path) -> None:
    """With a generator, episodes are picked without repeats, the same for the same seed."""
    draws = [[d.random_seed for d in stored_demos(root, TASK, 5, 0, rng=np.random.default_rng(1))] for _ in range(2)]
    assert draws[0] == draws[1]
    assert len(set(draws[0])) == 5


def test_paths_stand_for_pictures(root: Path) -> None:
    """With `image_paths`, an image field holds a text that gives the image when it is needed."""
    (demo,) = stored_demos(root, TASK, 1, 0, image_paths=True, random_selection=False, from_episode_number=3)
    whole = read_demo(episode_files(root, TASK, 0)[3])
    for observation, expected in zip(demo, whole, strict=True):
        assert isinstance(observation.front_rgb, str)
        assert_equal(read_image(observation.front_rgb), expected.front_rgb)
        assert_equal(observation.joint_positions, expected.joint_positions)
        assert observation.overhead_rgb is None
    with pytest.raises(DatasetError, match="is not a reference to an image"):
        read_image("episode3.h5")
    with pytest.raises(DatasetError, match="no front_rgb of frame 2"):
        read_image(str(demo[0].front_rgb)[:-1] + "2")


@pytest.mark.simulation
def test_load_all_variations(root: Path) -> None:
    """Variation -1 is every variation, amount -1 every episode."""
    assert len(stored_demos(root, TASK, -1, -1, random_selection=False)) == 13


def test_asking_for_too_many(root: Path) -> None:
    """The error has both numbers and the remedy."""
    with pytest.raises(DatasetError, match=r"13 demos.*has 12.*rlbench-pin record"):
        stored_demos(root, TASK, 13, 0)


def test_unknown_variation_task_and_root(root: Path) -> None:
    """Each missing thing is named, with what is there."""
    with pytest.raises(DatasetError, match=r"no variation 1 .*Choose one of \[0, 2\]"):
        stored_demos(root, TASK, 1, 1)
    with pytest.raises(DatasetError, match="Did you mean 'reach_target'"):
        stored_demos(root, "reach_targt", 1, 0)
    with pytest.raises(DatasetError, match="does not exist"):
        stored_demos(root / "nowhere", TASK, 1, 0)


def test_verify_finds_an_altered_file(root: Path) -> None:
    """One changed byte is found, and the file named."""
    path = episode_files(root, TASK, 0)[7]
    data = bytearray(path.read_bytes())
    data[-1] ^= 1
    path.write_bytes(bytes(data))
    with pytest.raises(DatasetError, match=r"episode7\.h5.*SHA-256"):
        verify_task(root, TASK)


def test_verify_finds_missing_and_unlisted_files(root: Path) -> None:
    """The manifest is compared with the folder, both ways."""
    path = episode_files(root, TASK, 0)[11]
    path.rename(path.with_name("episode20.h5"))
    with pytest.raises(DatasetError, match=r"episode11\.h5.*does not exist"):
        verify_task(root, TASK)
    path.with_name("episode20.h5").rename(path)
    (path.with_name("episode30.h5")).write_bytes(path.read_bytes())
    with pytest.raises(DatasetError, match=r"episode30\.h5.*not listed"):
        verify_task(root, TASK)


def test_a_broken_manifest_is_named(root: Path) -> None:
    """A manifest that is no JSON, or of another version, is an error with its path."""
    path = root / TASK / "manifest.json"
    content = json.loads(path.read_text())
    path.write_text(json.dumps({**content, "version": 7}))
    with pytest.raises(DatasetError, match=r"manifest\.json.*version 7.*version 1.*record again"):
        read_manifest(root, TASK)
    path.write_text("{")
    with pytest.raises(DatasetError, match=r"manifest\.json.*cannot be read"):
        read_manifest(root, TASK)


def test_a_demo_without_a_task_cannot_be_stored(tmp_path: Path) -> None:
    """The writer says what is missing."""
    with pytest.raises(DatasetError, match="task_name"):
        DatasetWriter(tmp_path).add(make_demo(task=""))


def test_manifest_path_is_relative(root: Path, tmp_path: Path) -> None:
    """A dataset can be moved as a whole."""
    moved = tmp_path.with_name(tmp_path.name + "_moved")
    root.rename(moved)
    verify_task(moved, TASK)
    assert len(read_demo(episode_files(moved, TASK, 2)[0])) == 2
