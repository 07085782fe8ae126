"""What comes from elsewhere is not trusted: damaged bytes, names that lead out of the folder, links to other files."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from rlbench_pin.datasets import (
    DatasetWriter,
    Episode,
    encode_demo,
    episode_entry,
    episode_files,
    episode_path,
    fold_journal,
    read_demo,
    read_manifest,
    stored_demos,
    stored_tasks,
    task_faults,
    verify_task,
    write_demo,
)
from rlbench_pin.datasets.manifest import append_entry
from rlbench_pin.datasets.merge import Move, merge
from rlbench_pin.datasets.storage import hold
from rlbench_pin.environment.stored import read_stored_descriptions
from rlbench_pin.errors import DatasetConflict, DatasetError, EpisodeFileError
from rlbench_pin.observation import Demo, Observation
from rlbench_pin.recording.config import PictureConfig
from rlbench_pin.recording.engines import SerialEngine
from rlbench_pin.recording.rerender import read_seeds, rerender
from tests.demos_for_tests import make_demo

TASK = "reach_target"


def fill(root: Path, seeds: range, frames: int = 2, variation: int = 0) -> Path:
    """Write made-up episodes and return the folder."""
    for seed in seeds:
        DatasetWriter(root, compression="lzf").add(make_demo(frames=frames, seed=seed, variation=variation))
    return root


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """Four episodes."""
    return fill(tmp_path / "data", range(4))


def edit(root: Path, **changes: object) -> None:
    """Change the second entry of the manifest."""
    path = root / TASK / "manifest.json"
    content = json.loads(path.read_text())
    content["episodes"][1].update(changes)
    path.write_text(json.dumps(content))


def write_seed(path: Path, **changes: object) -> None:
    """Write a list of one seed, some of it changed."""
    seed = {"task": TASK, "variation": 0, "episode": 0, "seed": 1, "attempt": 0, **changes}
    path.write_text(json.dumps({"format": "rlbench_pin.seeds", "version": 1, "episodes": [seed]}))


# Damage ---------------------------------------------------------------------------------------------------------------


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
    """A manifest that lies about seed or length is found by reading the file, and only then."""
    edit(root, random_seed=99)
    assert task_faults(root, TASK, structure=False) == []
    (fault,) = task_faults(root, TASK)
    assert "99" in str(fault)
    assert "episode1.h5" in str(fault)


def test_a_later_format_is_named(root: Path) -> None:
    """An episode of another format version is refused by reader and `verify` with both versions."""
    path = episode_files(root, TASK)[0]
    with h5py.File(path, "a") as file:
        file.attrs["version"] = 2
    with pytest.raises(EpisodeFileError, match=r"episode0\.h5.*version 2.*version 1.*record it again"):
        read_demo(path)


# What counts ----------------------------------------------------------------------------------------------------------


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
    with pytest.raises(DatasetError, match=r"5 demos.*holds 4"):
        stored_demos(root, TASK, 5, 0, random_selection=False)
    with pytest.raises(DatasetError, match=r"no variation 7 .* only \[0\]"):
        stored_demos(root, TASK, 1, 7, random_selection=False)
    with pytest.raises(DatasetError, match="holds 4 episodes"):
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


# The journal ----------------------------------------------------------------------------------------------------------


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


# Hostile names --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "file", ["../../secret.h5", "/etc/passwd", "variation0/episodes/../../../x.h5", "variation0/episodes/episode0.h5"]
)
def test_a_manifest_that_leads_elsewhere_is_refused(root: Path, tmp_path: Path, file: str) -> None:
    """No path of a manifest is followed but the one place where the episode belongs: not read, not merged, not verified."""
    (tmp_path / "secret.h5").write_bytes(b"secret")
    edit(root, file=file)
    with pytest.raises(EpisodeFileError, match=r"manifest\.json.*Do not trust"):
        read_manifest(root, TASK)
    with pytest.raises(EpisodeFileError, match="Do not trust"):
        stored_demos(root, TASK, 1, 0, random_selection=False)
    with pytest.raises(EpisodeFileError, match="Do not trust"):
        merge([root], tmp_path / "out")
    assert "Do not trust" in str(task_faults(root, TASK)[0])
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("change", [{"variation": -1}, {"episode": "../1"}, {"sha256": 7}, {"frames": None}, {"unknown": 1}])
def test_a_senseless_entry_is_refused(root: Path, change: dict[str, object]) -> None:
    """Numbers that are none, and keys that do not exist, make the manifest an error that is named."""
    edit(root, **change)
    with pytest.raises(EpisodeFileError, match=r"manifest\.json"):
        read_manifest(root, TASK)


@pytest.mark.parametrize("task", ["../reach_target", "/etc", "..", ".", "", "reach target", "a/b", "x" * 200])
def test_a_task_name_cannot_lead_out_of_the_folder(root: Path, task: str) -> None:
    """Reading and writing refuse names that are no names."""
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
    """Both versions and the remedy are told."""
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
        merge([root], tmp_path / "out")


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


# Merging --------------------------------------------------------------------------------------------------------------


def test_merging_keeps_every_episode(tmp_path: Path) -> None:
    """The result holds the same bytes under numbers of its own; merging again, or what is there already, adds nothing."""
    one, two = fill(tmp_path / "one", range(3)), fill(tmp_path / "two", range(2, 6))
    fill(two, range(2), variation=4)
    out = tmp_path / "out"
    assert len(merge([one, two], out)) == 8
    entries = read_manifest(out, TASK)
    assert [(e.variation, e.episode, e.random_seed) for e in entries] == [
        *((0, n, n) for n in range(6)), (4, 0, 0), (4, 1, 1),
    ]  # fmt: skip
    assert task_faults(out, TASK) == []
    assert merge([two, one], out) == ()
    assert read_manifest(out, TASK) == entries


def test_merging_into_a_folder_in_use_is_refused(tmp_path: Path) -> None:
    """While a recording holds the result nothing is merged, and the other way round: both would give the same numbers."""
    one, out = fill(tmp_path / "one", range(2)), fill(tmp_path / "out", range(5, 6))
    with hold(out), pytest.raises(DatasetConflict, match=r"into '.*out' is running\. Wait for it"):
        merge([one], out)
    assert len(read_manifest(out, TASK)) == len(episode_files(out, TASK)) == 1

    def hold_too(_: Move) -> None:
        with pytest.raises(DatasetConflict, match="is running"), hold(out):
            pass

    assert len(merge([one], out, hold_too)) == 2
    with hold(out):
        assert merge([one], out) == ()  # there is nothing to write


def test_merging_counts_on_from_a_recording_that_has_just_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Episodes that were stored after the first look at the result keep their numbers."""
    one, out = fill(tmp_path / "one", range(2)), fill(tmp_path / "out", range(5, 6))

    @contextmanager
    def hold_late(root: Path) -> Iterator[None]:
        fill(root, range(7, 8))
        with hold(root):
            yield

    monkeypatch.setattr("rlbench_pin.datasets.merge.hold", hold_late)
    merge([one], out)
    assert [entry.random_seed for entry in read_manifest(out, TASK)] == [5, 7, 0, 1]
    assert task_faults(out, TASK) == []


def test_merging_refuses_what_does_not_go_together(tmp_path: Path) -> None:
    """The same seed with other content, other pictures, or a bad file: an error, and nothing is written."""
    one, two = fill(tmp_path / "one", range(3)), fill(tmp_path / "two", range(2, 5), frames=3)
    with pytest.raises(DatasetConflict, match=r"episode0\.h5.*seed 2, but differ"):
        merge([one, two], tmp_path / "out")
    plain = make_demo(frames=2, seed=9)
    for observation in plain:
        observation.front_mask = None
    DatasetWriter(tmp_path / "three").add(plain)
    with pytest.raises(DatasetConflict, match="rerender"):
        merge([one, tmp_path / "three"], tmp_path / "out")
    assert not (tmp_path / "out").exists()
    episode_files(one, TASK)[1].write_bytes(b"not it")
    with pytest.raises(EpisodeFileError, match=r"episode1\.h5.*SHA-256"):
        merge([one], tmp_path / "out")
    with pytest.raises(DatasetError, match="does not exist"):
        merge([tmp_path / "nowhere"], tmp_path / "out")


# Lazily ---------------------------------------------------------------------------------------------------------------


def test_an_episode_is_read_as_far_as_it_is_used(tmp_path: Path) -> None:
    """Single frames and fields are those of the whole; a frame that is asked for reads no other picture."""
    demo = make_demo(frames=6)
    path = fill(tmp_path, range(1), frames=6) / TASK / "variation0" / "episodes" / "episode0.h5"
    whole = read_demo(path)
    with Episode(path) as episode:
        assert (len(episode), episode.task_name, episode.variation) == (6, TASK, 0)
        assert episode.instructions == demo.instructions
        assert episode.shape("front_rgb") == (12, 16, 3)
        assert np.array_equal(episode.array("joint_positions"), [obs.joint_positions for obs in whole])
        for index in (0, 4, -1):
            assert np.array_equal(episode[index].front_rgb, whole[index].front_rgb)
            assert episode[index].misc.keys() == whole[index].misc.keys()
        with pytest.raises(IndexError):
            episode[6]
        with pytest.raises(DatasetError, match="does not hold 'joint_forces'"):
            episode.array("joint_forces")


def test_a_frame_reads_no_other_picture(tmp_path: Path) -> None:
    """A damaged picture of one frame leaves the others readable, so they were not read for them; its own is an error."""
    pictures = np.random.default_rng(0).integers(0, 256, (6, 48, 48, 3), dtype=np.uint8)
    path = write_demo(Demo([Observation(front_rgb=picture) for picture in pictures], task_name=TASK), tmp_path / "e.h5")
    with h5py.File(path, "r") as file:
        offset = file["observations/front_rgb"].id.get_chunk_info(4).byte_offset
    with open(path, "r+b") as raw:
        raw.seek(offset)
        raw.write(bytes(64))
    with Episode(path) as episode:
        for index in (0, 3, 5):
            assert np.array_equal(episode[index].front_rgb, pictures[index])
        with pytest.raises(EpisodeFileError, match=r"e\.h5.*damaged"):
            episode[4]


def test_entries_are_plain(root: Path) -> None:
    """An entry is JSON and back."""
    for entry in read_manifest(root, TASK):
        assert type(entry)(**json.loads(json.dumps(asdict(entry)))) == entry
        assert replace(entry, failures=["x"]).failures == ["x"]
