"""What comes from elsewhere is not trusted: names that lead out of the folder, links to other files."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from rlbench_pin.datasets import (
    Compression,
    DatasetWriter,
    Episode,
    encode_demo,
    episode_entry,
    episode_files,
    merge_datasets,
    read_demo,
    read_image,
    read_manifest,
    stored_demos,
    stored_images,
    stored_tasks,
    task_faults,
    task_info,
    trust,
    verify,
    write_demo,
)
from rlbench_pin.datasets.formats.robomimic import export_robomimic
from rlbench_pin.datasets.manifest import file_digest
from rlbench_pin.datasets.trust import Inspector
from rlbench_pin.environment.stored import read_stored_descriptions
from rlbench_pin.errors import DatasetError, EpisodeFileError
from rlbench_pin.observation import Demo, Observation
from rlbench_pin.processes import SerialEngine
from rlbench_pin.recording.config import ImageConfig
from rlbench_pin.recording.replay import replay_stored
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
        rerender(path, tmp_path / "out", ImageConfig(products=()), engine=SerialEngine())
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("task", ["../reach_target", "reach_target.py", "/tmp/x.py", 7])
def test_a_list_of_seeds_with_a_hostile_task_is_refused(tmp_path: Path, task: object) -> None:
    """The name of a task leads neither out of the folder nor to a file with code."""
    write_seed(tmp_path / "seeds.json", task=task)
    with pytest.raises(EpisodeFileError, match=r"seeds\.json.*is not a list of seeds"):
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
    with pytest.raises(EpisodeFileError, match="is a link out of"):
        merge_datasets([root], tmp_path / "out")


@pytest.mark.simulation
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
        lambda: rerender(root, tmp_path / "again", ImageConfig(products=()), engine=SerialEngine()),
    )
    for call in calls:
        with pytest.raises(EpisodeFileError, match="is a link out of"):
            call()
    if below == TASK:
        with pytest.raises(EpisodeFileError, match="is a link out of"):
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
        with pytest.raises(EpisodeFileError, match="is a link out of"):
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
    {"task_version": 0}, {"task_version": "1"},
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


OTHER_TASK = "reach_target"
CRASH = "import os, signal, sys; sys.stdin.readline(); os.kill(os.getpid(), signal.SIGSEGV)"
HANG = "import sys, time; sys.stdin.readline(); time.sleep(600)"


def fake(program: str, seconds: float = 20.0) -> Inspector:
    """Return an inspector whose process does something else than reading."""
    return Inspector((sys.executable, "-c", program), seconds)


class TrustingInspector(Inspector):
    """An inspector that trusts every file: what the reader itself finds is under test."""

    def inspect(self, path: Path) -> None:
        """Do nothing."""


@pytest.fixture
def unlisted(tmp_path: Path) -> Path:
    """A file that lies in no dataset."""
    return write_demo(make_demo(frames=4), tmp_path / "somewhere.h5")


def test_a_file_that_crashes_the_library_is_an_error(unlisted: Path) -> None:
    """It says which file, and how the process that read it ended."""
    with fake(CRASH) as inspector, pytest.raises(EpisodeFileError, match=r"somewhere\.h5.*SIGSEGV.*Delete it") as caught:
        Episode(unlisted, inspector=inspector)
    assert caught.value.path == unlisted


def test_a_file_that_hangs_the_library_is_an_error(unlisted: Path) -> None:
    """After the time that it has, and the process is gone."""
    began = time.perf_counter()
    with fake(HANG, 0.5) as inspector, pytest.raises(EpisodeFileError, match=r"somewhere\.h5.*did not end within"):
        Episode(unlisted, inspector=inspector)
    assert time.perf_counter() - began < 15.0


def test_an_inspector_goes_on_after_a_crash(unlisted: Path) -> None:
    """The next file gets a new process."""
    with fake(CRASH) as inspector:
        for _ in range(2):
            with pytest.raises(EpisodeFileError, match="SIGSEGV"):
                inspector.inspect(unlisted)
    with Inspector() as inspector:
        for _ in range(2):
            inspector.inspect(unlisted)


def test_an_inspecting_process_waits_for_the_next_file(unlisted: Path) -> None:
    """The time limit of a file ends with its answer."""
    command = (sys.executable, "-m", "rlbench_pin.datasets.inspection_child")
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdin is not None and child.stdout is not None
        for wait in (1.5, 0.0):
            child.stdin.write(json.dumps([str(unlisted), 1]) + "\n")
            child.stdin.flush()
            assert child.stdout.readline() == "read\n"
            time.sleep(wait)
        child.stdin.close()
        assert child.wait(timeout=10.0) == 0


@pytest.mark.simulation
def test_damage_of_any_kind_is_read_or_refused(tmp_path: Path) -> None:
    """Flipped bits and zeroed blocks all over an unlisted file, some of which make the HDF5 library hang or crash."""
    data, rng, path = encode_demo(make_demo(frames=3)), np.random.default_rng(0), tmp_path / "episode.h5"
    refused = 0
    with Inspector(seconds=3.0) as inspector:
        for number in range(150):
            damaged = bytearray(data)
            where = int(rng.integers(len(data) if number % 3 else 3000))
            if number % 2:
                damaged[where] ^= 1 << int(rng.integers(8))
            else:
                damaged[where : where + 168] = bytes(168)
            path.write_bytes(damaged)
            try:
                with Episode(path, inspector=inspector) as episode:
                    episode.demo()
            except EpisodeFileError as error:
                assert "episode.h5" in str(error)
                refused += 1
    assert refused > 30


READERS: dict[str, Callable[[Path, Path], object]] = {
    "Episode": lambda root, file: Episode(file),
    "read_demo": lambda root, file: read_demo(file),
    "read_image": lambda root, file: read_image(f"{file}#front_rgb/0"),
    "stored_images": lambda root, file: stored_images(file),
    "stored_demos": lambda root, file: stored_demos(root, OTHER_TASK, -1, 0, random_selection=False),
    "image paths": lambda root, file: stored_demos(root, OTHER_TASK, -1, 0, random_selection=False, image_paths=True),
    "descriptions": lambda root, file: read_stored_descriptions(str(root), OTHER_TASK, 0),
    "info": lambda root, file: task_info(root, OTHER_TASK),
    "merge": lambda root, file: merge_datasets([root], root.parent / "out"),
    "export": lambda root, file: export_robomimic(root, root.parent / "out.hdf5"),
    "replay": lambda root, file: list(replay_stored([file])),
}


@pytest.mark.parametrize("name", READERS)
def test_a_listed_file_is_opened_only_with_its_checksum(root: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A byte that changed is found before the HDF5 library sees the file."""
    path = episode_files(root, OTHER_TASK)[0]
    stored_images(path)  # what is remembered of the file must not outlive the change
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(bytes(data))
    opened: list[object] = []
    real = h5py.File

    def opening(source: object, *args: object, **named: object) -> object:
        opened.append(source)
        return real(source, *args, **named)

    monkeypatch.setattr(h5py, "File", opening)
    with pytest.raises(EpisodeFileError, match=r"episode0\.h5.*SHA-256"):
        READERS[name](root, path)
    assert path not in opened


def counting_digests(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """Return a list to which each file is added when all its bytes are read for their SHA-256."""
    hashed: list[Path] = []

    def counting(path: Path) -> str:
        hashed.append(path)
        return file_digest(path)

    for module in (trust, verify):
        monkeypatch.setattr(module, "file_digest", counting)
    return hashed


def test_a_listed_file_is_hashed_once_in_a_process(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """However it is opened, with or without its SHA-256; a file that changed is hashed again, and `verify` always does."""
    hashed, entry = counting_digests(monkeypatch), read_manifest(root, OTHER_TASK)[0]
    path = root / OTHER_TASK / entry.file
    for _ in range(3):
        assert read_demo(path, sha256=entry.sha256)[0].front_rgb is not None
        with Episode(path) as episode:
            assert episode[1].front_rgb is not None
    assert hashed == [path]
    os.utime(path, (1, 1))
    read_demo(path, sha256=entry.sha256)
    assert hashed == [path] * 2
    for _ in range(2):
        assert task_faults(root, OTHER_TASK) == []
    assert hashed.count(path) == 4


def test_a_file_is_not_opened_in_place_of_the_one_that_was_hashed(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file that is replaced between its checksum and its opening is refused."""
    entry = read_manifest(root, OTHER_TASK)[0]
    path = root / OTHER_TASK / entry.file
    real = h5py.File

    def replaced(source: object, *args: object) -> object:
        write_demo(make_demo(frames=2, seed=77), path)
        return real(source, *args)

    monkeypatch.setattr(h5py, "File", lambda source, mode: replaced(source, mode) if source == path else real(source, mode))
    with pytest.raises(EpisodeFileError, match=r"episode0\.h5.*changed while it was opened"):
        Episode(path, entry.sha256)


@pytest.mark.parametrize("compression", ["gzip", "lzf"])
@pytest.mark.parametrize("field", ["front_rgb", "front_depth", "front_mask", "joint_positions"])
def test_a_flipped_bit_of_an_unlisted_file_is_an_error(tmp_path: Path, field: str, compression: Compression) -> None:
    """HDF5's own checksum finds it, wherever in the values it is; what deflate would pass on is no picture."""
    rng = np.random.default_rng(0)
    frames = [
        Observation(
            front_rgb=np.full((40, 40, 3), index, np.uint8),
            front_depth=rng.random((40, 40), dtype=np.float32),
            front_mask=np.full((40, 40), index, np.int32),
            joint_positions=rng.normal(size=7),
        )
        for index in range(9)
    ]
    path = write_demo(Demo(frames, task_name=TASK), tmp_path / "e.h5", compression)
    data = path.read_bytes()
    with h5py.File(path, "r") as file:
        stored = file[f"observations/{field}"].id
        chunks = [stored.get_chunk_info(number) for number in range(stored.get_num_chunks())]
    assert len(chunks) > 0
    for where in {chunk.byte_offset + int(chunk.size * part) for chunk in chunks for part in (0.0, 0.3, 0.7, 0.99)}:
        damaged = bytearray(data)
        damaged[where] ^= 1 << int(rng.integers(8))
        (tmp_path / "damaged.h5").write_bytes(bytes(damaged))
        with TrustingInspector() as inspector, pytest.raises(EpisodeFileError, match=r"damaged\.h5"):
            read_demo(tmp_path / "damaged.h5", inspector=inspector)


def test_verify_opens_no_altered_file(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where it reads the structure of the others."""
    for path in episode_files(root, OTHER_TASK):
        path.write_bytes(path.read_bytes()[:-1] + b"x")
    monkeypatch.setattr(h5py, "File", None)
    faults = task_faults(root, OTHER_TASK)
    assert len(faults) == 4 and all("SHA-256" in str(fault) for fault in faults)


@pytest.mark.simulation
def test_rerender_reads_no_altered_file(root: Path, tmp_path: Path) -> None:
    """The episode is not made, and the report says why."""
    path = episode_files(root, OTHER_TASK)[0]
    path.write_bytes(path.read_bytes()[:-1] + b"x")
    report = rerender(root, tmp_path / "out", ImageConfig(products=()), engine=SerialEngine())
    assert any("SHA-256" in text for result in report.failed for text in result.failures)


# Attributes -------------------------------------------------------------------------------------------------------------------

NESTED = "[" * 100_000 + "]" * 100_000


@pytest.mark.parametrize(
    "attribute",
    [
        {"frames": 0}, {"frames": 2.5}, {"frames": "4"}, {"frames": 10**12}, {"frames": [4, 4]}, {"variation": -1},
        {"variation": True}, {"variation": 2**40}, {"attempt": -1}, {"attempt": "x"}, {"task": 7}, {"task": "x" * 2000},
        {"task": np.arange(3)}, {"instructions": "[1, 2]"}, {"instructions": "{}"}, {"instructions": "not json"},
        {"instructions": NESTED}, {"versions": "[]"}, {"versions": '{"a": 1}'}, {"random_seed": -5}, {"random_seed": 0.5},
        {"num_reset_attempts": "many"}, {"random_state": "7"}, {"version": "1"}, {"version": [1, 1]}, {"descriptions": 3},
        {"task_version": 0}, {"task_version": 1.5},
    ],
    ids=lambda a: f"{next(iter(a))}={str(next(iter(a.values())))[:12]}",
)  # fmt: skip
def test_an_attribute_that_is_senseless_is_refused(unlisted: Path, attribute: dict[str, object]) -> None:
    """When the file is opened; the error names the file."""
    with h5py.File(unlisted, "a") as file:
        for name, value in attribute.items():
            file.attrs.create(name, value)
    with pytest.raises(EpisodeFileError, match=r"somewhere\.h5"):
        Episode(unlisted)


def change(path: Path, edit: Callable[[h5py.File], None]) -> None:
    """Edit an episode file."""
    with h5py.File(path, "a") as file:
        edit(file)


def replace_group(file: h5py.File) -> None:
    """Put an array where the group of fields belongs."""
    del file["misc"]
    file["misc"] = np.zeros(4)


def claim_much(file: h5py.File) -> None:
    """Declare an array of terabytes of which nothing is stored."""
    file["observations"].create_dataset("joint_forces", (1 << 40, 7), "f8", chunks=(1, 7))


def wrong_type(file: h5py.File) -> None:
    """Say that an array is a list of texts."""
    file["observations/joint_positions"].attrs["kind"] = "json"


def wrong_frames(file: h5py.File) -> None:
    """Say that a value belongs to frames that there are not."""
    del file["misc/joint_position_action@frames"]
    file["misc/joint_position_action@frames"] = np.array([1, -7, 2**40])


def deep_text(file: h5py.File) -> None:
    """Nest a text too deeply."""
    del file["misc/note"]
    dataset = file["misc"].create_dataset("note", data=[NESTED] * 4, dtype=h5py.string_dtype())
    dataset.attrs["kind"] = "json"


@pytest.mark.parametrize("edit", [replace_group, claim_much, wrong_type, wrong_frames, deep_text], ids=lambda f: f.__name__)
def test_contents_that_are_senseless_are_refused(unlisted: Path, edit: Callable[[h5py.File], None]) -> None:
    """By an error that names the file, in little time and memory."""
    change(unlisted, edit)
    with pytest.raises(DatasetError, match=r"somewhere\.h5"):
        read_demo(unlisted)
