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
    encode_demo,
    episode_entry,
    episode_files,
    read_demo,
    read_manifest,
    stored_demos,
    stored_tasks,
    task_faults,
    task_info,
)
from rlbench_pin.datasets.merge import merge_datasets
from rlbench_pin.errors import DatasetError, EpisodeFileError
from rlbench_pin.processes import SerialEngine
from rlbench_pin.recording.config import PictureConfig
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
    (root / TASK / "manifest.json").unlink()  # otherwise the SHA-256 says that they were altered
    with h5py.File(linked, "a") as file:
        file["observations/joint_forces"] = h5py.ExternalLink("../../../../secret.h5", "joint_forces")
    with h5py.File(external, "a") as file:
        (tmp_path / "raw").write_bytes(bytes(112))
        file["observations"].create_dataset("joint_forces", (2, 7), "f8", external=[(str(tmp_path / "raw"), 0, 112)])
    with pytest.raises(EpisodeFileError, match="Do not trust"):
        read_demo(linked)
    with pytest.raises(EpisodeFileError, match="Do not trust"):
        read_demo(external)


@pytest.mark.parametrize("below", [TASK, f"{TASK}/variation0", f"{TASK}/variation0/episodes"])
def test_a_folder_that_is_a_link_out_of_the_dataset_is_not_followed(root: Path, tmp_path: Path, below: str) -> None:
    """Neither read nor written, listed or not."""
    shutil.move(root / below, tmp_path / "elsewhere")
    (root / below).symlink_to(tmp_path / "elsewhere")
    before = sorted((tmp_path / "elsewhere").rglob("*"))
    calls = (
        lambda: stored_demos(root, TASK, 1, 0, random_selection=False),
        lambda: merge_datasets([root], tmp_path / "out"),
        lambda: DatasetWriter(root).add(make_demo(frames=2, seed=77)),
        lambda: task_faults(root, TASK) and [_raise(fault) for fault in task_faults(root, TASK)],
        lambda: rerender(root, tmp_path / "again", PictureConfig(products=()), engine=SerialEngine()),
    )
    for call in calls:
        with pytest.raises(EpisodeFileError, match="leads out of"):
            call()
    if below == TASK:
        with pytest.raises(EpisodeFileError, match="leads out of"):
            stored_tasks(root)
    assert sorted((tmp_path / "elsewhere").rglob("*")) == before


def _raise(error: Exception) -> None:
    raise error


def test_a_manifest_that_is_a_link_out_of_the_dataset_is_not_followed(root: Path, tmp_path: Path) -> None:
    """Nor is its journal, into which new entries would be written."""
    (tmp_path / "victim").write_text("precious\n")
    (root / TASK / ".manifest.journal").symlink_to(tmp_path / "victim")
    demo = make_demo(frames=2, seed=9)
    data = encode_demo(demo)
    for call in (lambda: DatasetWriter(root).put(TASK, data, episode_entry(demo, data, 9)), lambda: read_manifest(root, TASK)):
        with pytest.raises(EpisodeFileError, match="leads out of"):
            call()
    assert (tmp_path / "victim").read_text() == "precious\n"


def test_links_within_a_dataset_and_to_it_are_followed(root: Path, tmp_path: Path) -> None:
    """A dataset may lie behind a link, and an episode on another disk of the same tree may not."""
    (tmp_path / "link").symlink_to(root)
    assert len(stored_demos(tmp_path / "link", TASK, -1, 0, random_selection=False)) == 4
    (root / "kept").mkdir()
    shutil.move(root / TASK / "variation0", root / "kept" / "variation0")
    (root / TASK / "variation0").symlink_to(root / "kept" / "variation0")
    assert len(stored_demos(root, TASK, -1, 0, random_selection=False)) == 4


SENSELESS = (
    {"frames": 0}, {"frames": 10**9}, {"frames": 1.0}, {"variation": 2**40}, {"variation": False}, {"episode": 10**30},
    {"random_seed": "1"}, {"random_seed": -1}, {"random_seed": 2**70}, {"random_seed": True}, {"num_bytes": -3},
    {"sha256": "abc"}, {"sha256": "Z" * 64}, {"instructions": "text"}, {"instructions": [1]}, {"instructions": None},
    {"versions": []}, {"versions": {"numpy": 2}}, {"failures": {"a": 1}}, {"failures": [["deep"]]}, {"file": None},
)  # fmt: skip


@pytest.mark.parametrize("change", SENSELESS, ids=str)
def test_an_entry_out_of_type_or_range_is_refused(root: Path, change: dict[str, object]) -> None:
    """With the name of the manifest and of the field; nothing fails later on."""
    edit_manifest(root, **change)
    with pytest.raises(EpisodeFileError, match=rf"manifest\.json.*{next(iter(change))}"):
        read_manifest(root, TASK)
    with pytest.raises(EpisodeFileError, match=r"manifest\.json"):
        task_info(root, TASK)


DEEP = "[" * 200_000
BAD_JSON = (
    DEEP, "[]", "7", "null", '"text"', "", "\x00", "{", '{"version": 1}', '{"version": 1, "episodes": 7}',
    '{"version": 1, "episodes": [7]}', '{"version": 1, "episodes": {"a": 1}}', '{"version": [1], "episodes": []}',
    '{"version": 1, "episodes": [], "task": 7}', '{"version": 1, "episodes": [], "task": ["reach_target"]}',
    '{"version": NaN, "episodes": []}', '{"version": 1, "episodes": [' + "1" * 5000 + "]}", '{"version": 1, "episodes": ' + DEEP,
)  # fmt: skip


@pytest.mark.parametrize("text", BAD_JSON, ids=lambda text: repr(text[:40]))
def test_a_manifest_that_is_no_manifest_is_refused(root: Path, text: str) -> None:
    """Whatever it is instead, and however deeply it is nested; so is a journal."""
    manifest = root / TASK / "manifest.json"
    manifest.write_text(text)
    with pytest.raises(EpisodeFileError, match=r"manifest\.json"):
        read_manifest(root, TASK)
    if not text.startswith("{"):
        manifest.unlink()
        (root / TASK / ".manifest.journal").write_text(text + "\n")
        if text.strip():
            with pytest.raises(EpisodeFileError, match="journal"):
                read_manifest(root, TASK)
