"""Recording loses nothing, repeats nothing, and gives the same files whoever does the work."""

from __future__ import annotations

import errno
import json
import os
import subprocess
import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.datasets import episode_files, read_demo, read_manifest, stored_demos, task_faults, verify_task
from rlbench_pin.datasets.layout import episode_path
from rlbench_pin.datasets.storage import hold
from rlbench_pin.errors import DatasetConflict, DatasetError, StorageError
from rlbench_pin.processes import SerialEngine
from rlbench_pin.recording.config import ImageConfig, RecordConfig, plan_items, read_recording, write_recording
from rlbench_pin.recording.record import RecordReport, record
from tests.demos_for_tests import mounted, simulate_full_disk
from tests.engines_for_tests import MadeUpEngine

TASK = "reach_target"
CONFIG = RecordConfig(tasks=(TASK,), episodes=6, variations=2, max_attempts=3, images=ImageConfig(products=()))


def manifest(root: Path) -> bytes:
    """The bytes of the manifest: seeds, attempts, failures and SHA-256 of every episode."""
    return (root / TASK / "manifest.json").read_bytes()


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording that nothing went wrong with."""
    root = tmp_path_factory.mktemp("undisturbed")
    record(CONFIG, root, engine=MadeUpEngine(retried=[1]))
    return root


# The result -----------------------------------------------------------------------------------------------------------


@pytest.mark.simulation
def test_a_recording_holds_what_was_asked_for(tmp_path: Path) -> None:
    """Real demonstrations, each equal to the one that its seed gives by hand; the manifest and the files agree."""
    config = replace(CONFIG, episodes=3)
    report = record(config, tmp_path, engine=SerialEngine())
    assert (report.wanted, report.found, report.recorded, report.missing) == (3, 0, 3, 0)
    verify_task(tmp_path, TASK, structure=True)
    with config.images.environment() as environment:
        task = environment.get_task(TASK)
        for item in plan_items(config):
            stored = read_demo(episode_path(tmp_path, *item.key))
            again = task.try_demo(seed=item.seed, variation=item.variation, attempt=stored.attempt).demo
            assert again is not None
            joints, before = ([obs.joint_positions for obs in demo] for demo in (again, stored))
            assert np.array_equal(np.array(joints), np.array(before))
            assert again.instructions == stored.instructions


def test_the_order_of_the_work_changes_nothing(tmp_path: Path, undisturbed: Path) -> None:
    """Episodes that come back in another order make the same manifest and the same files."""
    record(CONFIG, tmp_path, engine=MadeUpEngine(backwards=True, retried=[1]))
    assert manifest(tmp_path) == manifest(undisturbed)
    for a, b in zip(episode_files(tmp_path, TASK), episode_files(undisturbed, TASK), strict=True):
        assert a.read_bytes() == b.read_bytes()


def test_retries_are_recorded(undisturbed: Path) -> None:
    """The manifest says why the first try of an episode failed."""
    assert {entry.episode: entry.failures for entry in read_manifest(undisturbed, TASK)} == {
        0: [], 1: ["DemoError: it fell"], 2: [],
    }  # fmt: skip


def test_failures_are_reported_and_cost_nothing_else(tmp_path: Path) -> None:
    """An episode that cannot be made is in the report with its causes; all others are stored; a later run tries it again."""
    seen: list[RecordReport] = []
    report = record(CONFIG, tmp_path, engine=MadeUpEngine(failing=[1]), on_progress=seen.append)
    assert (report.recorded, report.missing) == (4, 2)
    assert [result.item.index for result in report.failed] == [1, 1]
    assert report.causes == {"no path": 6}
    assert [r.recorded + len(r.failed) for r in seen] == list(range(7))
    again = record(CONFIG, tmp_path, engine=MadeUpEngine(), resume=True)
    assert (again.found, again.recorded, again.missing) == (4, 2, 0)
    verify_task(tmp_path, TASK)


# Going on -------------------------------------------------------------------------------------------------------------


def test_a_stopped_recording_goes_on(tmp_path: Path, undisturbed: Path) -> None:
    """Stopping begins nothing more and leaves a sound dataset; resuming makes only what is missing."""
    stop = threading.Event()
    first = record(
        CONFIG,
        tmp_path,
        engine=MadeUpEngine(retried=[1]),
        stop=stop,
        on_progress=lambda r: stop.set() if r.recorded == 2 else None,
    )
    assert (first.recorded, first.missing) == (2, 4)
    verify_task(tmp_path, TASK)
    engine = MadeUpEngine(retried=[1])
    record(CONFIG, tmp_path, engine=engine, resume=True)
    assert len(engine.begun) == 4
    assert manifest(tmp_path) == manifest(undisturbed)


def test_an_interrupt_leaves_a_sound_dataset(tmp_path: Path, undisturbed: Path) -> None:
    """An exception out of nowhere, as Ctrl-C is, loses no episode that was stored."""

    def interrupt(report: RecordReport) -> None:
        if report.recorded == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        record(CONFIG, tmp_path, engine=MadeUpEngine(retried=[1]), on_progress=interrupt)
    verify_task(tmp_path, TASK)
    assert len(read_manifest(tmp_path, TASK)) == 3
    record(read_recording(tmp_path), tmp_path, engine=MadeUpEngine(retried=[1]), resume=True)
    assert manifest(tmp_path) == manifest(undisturbed)


@pytest.mark.simulation
def test_what_a_killed_writer_left_does_not_count(tmp_path: Path, undisturbed: Path) -> None:
    """Parts are removed; a file that was written but not listed, listed but deleted, or cut off is made again."""
    record(CONFIG, tmp_path, engine=MadeUpEngine(retried=[1]))
    entries = read_manifest(tmp_path, TASK)
    files = [tmp_path / TASK / entry.file for entry in entries]
    content = json.loads(manifest(tmp_path))
    content["episodes"] = content["episodes"][1:]
    (tmp_path / TASK / "manifest.json").write_text(json.dumps(content))
    part = files[0].with_name(".episode0.h5.1234.part")
    part.write_bytes(b"half")
    files[1].unlink()
    files[2].write_bytes(files[2].read_bytes()[:100])
    engine = MadeUpEngine(retried=[1])
    report = record(CONFIG, tmp_path, engine=engine, resume=True)
    assert (report.found, report.recorded, len(engine.begun)) == (3, 3, 3)
    assert not part.exists()
    assert manifest(tmp_path) == manifest(undisturbed)
    assert task_faults(tmp_path, TASK) == []


@pytest.mark.simulation
def test_a_dataset_can_grow(tmp_path: Path) -> None:
    """More episodes or tasks are added to what is there; what is there stays as it is."""
    record(CONFIG, tmp_path, engine=MadeUpEngine())
    before = {path: path.read_bytes() for path in episode_files(tmp_path, TASK)}
    report = record(
        replace(CONFIG, episodes=8, tasks=(TASK, "push_button")), tmp_path, engine=MadeUpEngine(), resume=True
    )  # fmt: skip
    assert (report.found, report.recorded) == (6, 10)
    assert {path: path.read_bytes() for path in before} == before


def test_a_folder_that_is_in_use_is_refused(tmp_path: Path, undisturbed: Path) -> None:
    """Recording onto a dataset, with other settings, or beside a running recording, is an error that says what to do."""
    with pytest.raises(DatasetConflict, match="--resume"):
        record(CONFIG, undisturbed, engine=MadeUpEngine())
    with pytest.raises(DatasetConflict, match="was recorded with `--seed 0`, not with `--seed 1`"):
        record(replace(CONFIG, seed=1), undisturbed, engine=MadeUpEngine(), resume=True)
    with pytest.raises(DatasetConflict, match="with `--products`, not with `--products rgb depth mask`"):
        record(replace(CONFIG, images=ImageConfig()), undisturbed, engine=MadeUpEngine(), resume=True)
    with hold(tmp_path), pytest.raises(DatasetConflict, match="is running"):
        record(CONFIG, tmp_path, engine=MadeUpEngine())


def test_other_settings_are_shown_as_flags(tmp_path: Path) -> None:
    """Those that differ, as they are typed; also where nothing but the settings was stored yet."""
    write_recording(tmp_path, CONFIG)
    other = replace(CONFIG, episodes=9, images=replace(CONFIG.images, image_size=(64, 32)))
    with pytest.raises(DatasetConflict) as caught:
        record(other, tmp_path, engine=MadeUpEngine())
    width, height = CONFIG.images.image_size
    assert f"with `--episodes {CONFIG.episodes} --image-size {width} {height}`" in str(caught.value)
    assert "not with `--episodes 9 --image-size 64 32`" in str(caught.value) and "ImageConfig(" not in str(caught.value)
    assert read_recording(tmp_path) == CONFIG
    assert record(CONFIG, tmp_path, engine=MadeUpEngine()).recorded == 6


def test_a_foreign_episode_in_the_place_of_one_is_refused(tmp_path: Path, undisturbed: Path) -> None:
    """Files of another recording are never taken for those of this one, nor overwritten."""
    record(CONFIG, tmp_path, engine=MadeUpEngine())
    (tmp_path / "recording.json").unlink()
    with pytest.raises(DatasetConflict, match="instead of"):
        record(replace(CONFIG, seed=5), tmp_path, engine=MadeUpEngine(), resume=True)


def test_episodes_of_another_version_of_a_task_are_refused(tmp_path: Path) -> None:
    """A dataset has one version of a task."""
    record(CONFIG, tmp_path, engine=MadeUpEngine())
    path = tmp_path / TASK / "manifest.json"
    content = json.loads(path.read_bytes())
    for entry in content["episodes"]:
        entry["task_version"] = 2
    path.write_text(json.dumps(content))
    with pytest.raises(DatasetConflict, match="version 2 of 'reach_target', but the installed task has version 1"):
        record(replace(CONFIG, episodes=9), tmp_path, engine=MadeUpEngine(), resume=True)


def test_settings_come_back(undisturbed: Path, tmp_path: Path) -> None:
    """What was recorded is written beside it; a missing or senseless file is named."""
    assert read_recording(undisturbed) == CONFIG
    with pytest.raises(DatasetError, match=r"recording\.json.*does not exist"):
        read_recording(tmp_path)
    (tmp_path / "recording.json").write_text('{"version": 1, "tasks": ["reach_target"], "images": {"zoom": 3}}')
    with pytest.raises(DatasetError, match=r"recording\.json.*zoom"):
        read_recording(tmp_path)
    (tmp_path / "recording.json").write_text('{"version": 7}')
    with pytest.raises(DatasetError, match=r"recording\.json.*version 7.*version 1.*Delete it.*the tasks and the settings"):
        read_recording(tmp_path)


# Disks ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("call", range(2, 12))
def test_a_full_disk_loses_nothing(tmp_path: Path, undisturbed: Path, monkeypatch: pytest.MonkeyPatch, call: int) -> None:
    """Whenever the disk is full, the error says so, what was stored is sound, and the recording goes on later."""
    simulate_full_disk(monkeypatch, after=call)
    with pytest.raises(StorageError, match="No space left.*--resume"):
        record(CONFIG, tmp_path, engine=MadeUpEngine(retried=[1]))
    monkeypatch.undo()
    entries = read_manifest(tmp_path, TASK) if (tmp_path / TASK).exists() else ()
    assert all((tmp_path / TASK / entry.file).is_file() for entry in entries)
    assert not list(tmp_path.rglob("*.part"))
    report = record(CONFIG, tmp_path, engine=MadeUpEngine(retried=[1]), resume=True)
    assert report.found == len(entries)
    assert manifest(tmp_path) == manifest(undisturbed)


@pytest.mark.parametrize("code", [errno.EROFS, errno.EACCES])
def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: int) -> None:
    """A read-only disk and missing rights are errors with path and remedy (simulated: root may write anywhere)."""

    def mkdir(self: Path, *_: object, **__: object) -> None:
        raise OSError(code, os.strerror(code), str(self))

    monkeypatch.setattr(Path, "mkdir", mkdir)
    with pytest.raises(StorageError, match=r"data.*choose another folder") as caught:
        record(CONFIG, tmp_path / "data", engine=MadeUpEngine())
    assert caught.value.errno == code


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A disk of 300 kB of its own, where this machine lets tests mount one."""
    with mounted(tmp_path / "disk", kilobytes=300) as folder:
        yield folder


@pytest.mark.simulation
def test_a_disk_that_is_really_full(small_disk: Path, undisturbed: Path) -> None:
    """A file that fills the disk is found out, removed, and made when there is room; a read-only disk is still read."""
    ballast = small_disk / "ballast"
    needed = sum(path.stat().st_size for path in episode_files(undisturbed, TASK))
    ballast.write_bytes(bytes(300 * 1024 - needed * 2 // 3))
    with pytest.raises(StorageError, match="No space left") as caught:
        record(CONFIG, small_disk / "data", engine=MadeUpEngine(retried=[1]))
    assert caught.value.errno == errno.ENOSPC
    root = small_disk / "data"
    stored = len(read_manifest(root, TASK))
    assert 0 < stored < 6
    assert task_faults(root, TASK) == []
    ballast.unlink()
    assert record(CONFIG, root, engine=MadeUpEngine(retried=[1]), resume=True).found == stored
    assert manifest(root) == manifest(undisturbed)
    subprocess.run(["mount", "-o", "remount,ro", str(small_disk)], check=True)
    with pytest.raises(StorageError, match="read-only"):
        record(replace(CONFIG, episodes=8), root, engine=MadeUpEngine(), resume=True)
    assert len(stored_demos(root, TASK, -1, -1, random_selection=False)) == 6


def test_a_file_in_the_way_is_named(tmp_path: Path) -> None:
    """A root below a file cannot be made; the error is ours."""
    (tmp_path / "file").write_text("")
    with pytest.raises(StorageError, match=r"file/data.*cannot be written"):
        record(CONFIG, tmp_path / "file" / "data", engine=MadeUpEngine())
