"""Damaged files end in an error of ours, whatever the HDF5 library does with them."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from rlbench_pin.datasets import (
    Episode,
    encode_demo,
    episode_files,
    merge_datasets,
    read_demo,
    read_picture,
    stored_demos,
    stored_pictures,
    task_faults,
    task_info,
    write_demo,
)
from rlbench_pin.datasets.formats.robomimic import export_robomimic
from rlbench_pin.datasets.trust import Inspector
from rlbench_pin.environment.stored import read_stored_descriptions
from rlbench_pin.errors import DatasetError, EpisodeFileError
from rlbench_pin.processes import SerialEngine
from rlbench_pin.recording.config import PictureConfig
from rlbench_pin.recording.replay import replay_stored
from rlbench_pin.recording.rerender import rerender
from tests.demos_for_tests import make_demo

TASK = "reach_target"
CRASH = "import os, signal, sys; sys.stdin.readline(); os.kill(os.getpid(), signal.SIGSEGV)"
HANG = "import sys, time; sys.stdin.readline(); time.sleep(600)"


def fake(program: str, seconds: float = 20.0) -> Inspector:
    """Return an inspector whose process does something else than reading."""
    return Inspector((sys.executable, "-c", program), seconds)


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
    "read_picture": lambda root, file: read_picture(f"{file}#front_rgb/0"),
    "stored_pictures": lambda root, file: stored_pictures(file),
    "stored_demos": lambda root, file: stored_demos(root, TASK, -1, 0, random_selection=False),
    "image paths": lambda root, file: stored_demos(root, TASK, -1, 0, random_selection=False, image_paths=True),
    "descriptions": lambda root, file: read_stored_descriptions(str(root), TASK, 0),
    "info": lambda root, file: task_info(root, TASK),
    "merge": lambda root, file: merge_datasets([root], root.parent / "out"),
    "export": lambda root, file: export_robomimic(root, root.parent / "out.hdf5"),
    "replay": lambda root, file: list(replay_stored([file])),
}


@pytest.mark.parametrize("name", READERS)
def test_a_listed_file_is_opened_only_with_its_checksum(root: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A byte that changed is found before the HDF5 library sees the file."""
    path = episode_files(root, TASK)[0]
    stored_pictures(path)  # what is remembered of the file must not outlive the change
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


def test_verify_opens_no_altered_file(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where it reads the structure of the others."""
    for path in episode_files(root, TASK):
        path.write_bytes(path.read_bytes()[:-1] + b"x")
    monkeypatch.setattr(h5py, "File", None)
    faults = task_faults(root, TASK)
    assert len(faults) == 4 and all("SHA-256" in str(fault) for fault in faults)


@pytest.mark.simulation
def test_rerender_reads_no_altered_file(root: Path, tmp_path: Path) -> None:
    """The episode is not made, and the report says why."""
    path = episode_files(root, TASK)[0]
    path.write_bytes(path.read_bytes()[:-1] + b"x")
    report = rerender(root, tmp_path / "out", PictureConfig(products=()), engine=SerialEngine())
    assert any("SHA-256" in text for result in report.failed for text in result.failures)


# Attributes -------------------------------------------------------------------------------------------------------------------

DEEP = "[" * 100_000 + "]" * 100_000


@pytest.mark.parametrize(
    "attribute",
    [
        {"frames": 0}, {"frames": 2.5}, {"frames": "4"}, {"frames": 10**12}, {"frames": [4, 4]}, {"variation": -1},
        {"variation": True}, {"variation": 2**40}, {"attempt": -1}, {"attempt": "x"}, {"task": 7}, {"task": "x" * 2000},
        {"task": np.arange(3)}, {"instructions": "[1, 2]"}, {"instructions": "{}"}, {"instructions": "not json"},
        {"instructions": DEEP}, {"versions": "[]"}, {"versions": '{"a": 1}'}, {"random_seed": -5}, {"random_seed": 0.5},
        {"num_reset_attempts": "many"}, {"random_state": "7"}, {"version": "1"}, {"version": [1, 1]}, {"descriptions": 3},
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
    dataset = file["misc"].create_dataset("note", data=[DEEP] * 4, dtype=h5py.string_dtype())
    dataset.attrs["kind"] = "json"


@pytest.mark.parametrize("edit", [replace_group, claim_much, wrong_type, wrong_frames, deep_text], ids=lambda f: f.__name__)
def test_contents_that_are_senseless_are_refused(unlisted: Path, edit: Callable[[h5py.File], None]) -> None:
    """By an error that names the file, in little time and memory."""
    change(unlisted, edit)
    with pytest.raises(DatasetError, match=r"somewhere\.h5"):
        read_demo(unlisted)
