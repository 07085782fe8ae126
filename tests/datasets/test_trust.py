"""What comes from elsewhere is not trusted: names that lead out of the folder, links to other files."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from rlbench_pin.datasets import (
    DatasetWriter,
    episode_entry,
    episode_files,
    read_demo,
    read_manifest,
    stored_demos,
    stored_tasks,
    task_faults,
)
from rlbench_pin.datasets.merge import merge_datasets
from rlbench_pin.errors import DatasetError, EpisodeFileError
from rlbench_pin.recording.config import PictureConfig
from rlbench_pin.recording.engines import SerialEngine
from rlbench_pin.recording.rerender import read_seeds, rerender
from tests.demos_for_tests import edit_manifest, make_demo

TASK = "reach_target"


def write_seed(path: Path, **changes: object) -> None:
    """Write a list of one seed, some of it changed."""
    seed = {"task": TASK, "variation": 0, "episode": 0, "seed": 1, "attempt": 0, **changes}
    path.write_text(json.dumps({"format": "rlbench_pin.seeds", "version": 1, "episodes": [seed]}))


@pytest.mark.parametrize(
    "file", ["../../secret.h5", "/etc/passwd", "variation0/episodes/../../../x.h5", "variation0/episodes/episode0.h5"]
)
def test_a_manifest_that_leads_elsewhere_is_refused(root: Path, tmp_path: Path, file: str) -> None:
    """No path of a manifest is followed but the one place where the episode belongs: not read, not merged, not verified."""
    (tmp_path / "secret.h5").write_bytes(b"secret")
    edit_manifest(root, file=file)
    with pytest.raises(EpisodeFileError, match=r"manifest\.json.*Do not trust"):
        read_manifest(root, TASK)
    with pytest.raises(EpisodeFileError, match="Do not trust"):
        stored_demos(root, TASK, 1, 0, random_selection=False)
    with pytest.raises(EpisodeFileError, match="Do not trust"):
        merge_datasets([root], tmp_path / "out")
    assert "Do not trust" in str(task_faults(root, TASK)[0])
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("change", [{"variation": -1}, {"episode": "../1"}, {"sha256": 7}, {"frames": None}, {"unknown": 1}])
def test_a_senseless_entry_is_refused(root: Path, change: dict[str, object]) -> None:
    """Numbers that are none, and keys that do not exist, make the manifest an error that is named."""
    edit_manifest(root, **change)
    with pytest.raises(EpisodeFileError, match=r"manifest\.json"):
        read_manifest(root, TASK)


@pytest.mark.parametrize("task", ["../reach_target", "/etc", "..", ".", "", "reach target", "a/b", "x" * 200])
def test_a_task_name_cannot_lead_out_of_the_folder(root: Path, task: str) -> None:
    """Reading and writing refuse names that cannot be folders."""
    with pytest.raises(DatasetError):
        stored_demos(root, task, 1, 0, random_selection=False)
    with pytest.raises(DatasetError):
        DatasetWriter(root).add(make_demo(frames=2, task=task))
    assert stored_tasks(root) == (TASK,)


def test_a_manifest_of_another_task_is_refused(root: Path) -> None:
    """A folder that was renamed is not taken for another task."""
    (root / TASK).rename(root / "push_button")
    with pytest.raises(EpisodeFileError, match="is of the task 'reach_target'"):
        read_manifest(root, "push_button")


@pytest.mark.parametrize("name", ["episode00.h5", "episode\u0661.h5", "episode-1.h5", "episode1.h5\n"])
def test_only_names_that_the_writer_gives_are_episodes(root: Path, name: str) -> None:
    """Zeros in front, digits of other scripts, signs and line ends make no second episode of a number, nor a second variation."""
    files = episode_files(root, TASK)
    (files[0].parent / name).write_bytes(files[0].read_bytes())
    for variation in ("variation00", "variation\u0660"):
        shutil.copytree(files[0].parents[1], files[0].parents[2] / variation)
    assert episode_files(root, TASK) == files
    assert len(stored_demos(root, TASK, -1, -1, random_selection=False)) == 4


@pytest.mark.parametrize(
    "change",
    [
        {"episode": "0/../../../../../outside"},
        {"variation": "0/../../../../outside"},
        {"episode": -1},
        {"variation": True},
        {"attempt": None},
    ],
)
def test_a_list_of_seeds_that_leads_elsewhere_is_refused(tmp_path: Path, change: dict[str, object]) -> None:
    """The numbers of a list of seeds become paths, so they have to be numbers; nothing is made and nothing written."""
    path = tmp_path / "seeds.json"
    write_seed(path, **change)
    name = next(iter(change))
    with pytest.raises(EpisodeFileError, match=rf"seeds\.json.*{name}=.*rlbench-pin dataset seeds"):
        rerender(path, tmp_path / "out", PictureConfig(products=()), engine=SerialEngine())
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("task", ["../reach_target", "reach_target.py", "/tmp/x.py", 7])
def test_a_list_of_seeds_with_a_hostile_task_is_refused(tmp_path: Path, task: object) -> None:
    """The name of a task leads neither out of the folder nor to a file with code."""
    write_seed(tmp_path / "seeds.json", task=task)
    with pytest.raises(EpisodeFileError, match=r"seeds\.json.*holds no list of seeds"):
        read_seeds(tmp_path / "seeds.json")


def test_a_list_of_seeds_of_a_later_format_is_named(tmp_path: Path) -> None:
    """The error says both versions and the remedy."""
    (tmp_path / "seeds.json").write_text('{"format": "rlbench_pin.seeds", "version": 2, "episodes": []}')
    with pytest.raises(EpisodeFileError, match=r"seeds\.json.*version 2.*version 1.*rlbench-pin dataset seeds"):
        read_seeds(tmp_path / "seeds.json")


def test_the_writer_follows_no_entry_out_of_its_folder(tmp_path: Path) -> None:
    """An entry with a path for a number is refused before anything is written, whoever made it."""
    entry = episode_entry(make_demo(frames=2), b"", 0)
    with pytest.raises(EpisodeFileError, match="Restore it"):
        DatasetWriter(tmp_path / "data").put(TASK, b"", replace(entry, episode="0/../../../../../outside"))  # type: ignore[arg-type]
    with pytest.raises(EpisodeFileError, match="Do not trust"):
        DatasetWriter(tmp_path / "data").put(TASK, b"", replace(entry, file="../outside.h5"))
    assert list(tmp_path.iterdir()) == []


def test_a_link_out_of_the_folder_is_not_merged(root: Path, tmp_path: Path) -> None:
    """An episode that is a symbolic link to elsewhere is refused, though its bytes add up."""
    path = episode_files(root, TASK)[0]
    path.rename(tmp_path / "elsewhere.h5")
    path.symlink_to(tmp_path / "elsewhere.h5")
    with pytest.raises(EpisodeFileError, match="leads out of"):
        merge_datasets([root], tmp_path / "out")


def test_a_file_that_reads_other_files_is_refused(root: Path, tmp_path: Path) -> None:
    """Links and storage outside the episode file are not followed."""
    with h5py.File(tmp_path / "secret.h5", "w") as file:
        file["joint_forces"] = np.zeros((2, 7))
    linked, external = episode_files(root, TASK)[:2]
    with h5py.File(linked, "a") as file:
        file["observations/joint_forces"] = h5py.ExternalLink("../../../../secret.h5", "joint_forces")
    with h5py.File(external, "a") as file:
        (tmp_path / "raw").write_bytes(bytes(112))
        file["observations"].create_dataset("joint_forces", (2, 7), "f8", external=[(str(tmp_path / "raw"), 0, 112)])
    with pytest.raises(EpisodeFileError, match="Do not trust"):
        read_demo(linked)
    with pytest.raises(EpisodeFileError, match="Do not trust"):
        read_demo(external)
