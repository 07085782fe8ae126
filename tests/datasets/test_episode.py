"""An episode file gives back what was put in, and says so when it cannot."""

from __future__ import annotations

import dataclasses
import json
import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest

from rlbench_pin.datasets import DatasetWriter, Episode, read_demo, read_manifest, write_demo
from rlbench_pin.datasets.series import read_series, write_series
from rlbench_pin.datasets.verify import verify_task
from rlbench_pin.datasets.writer import encode_demo
from rlbench_pin.errors import DatasetError, EpisodeFileError, InvalidValue
from rlbench_pin.observation import Demo, Observation
from tests.demos_for_tests import assert_equal, fill, make_demo


@pytest.fixture
def episode(tmp_path: Path) -> Path:
    """One episode on disk."""
    return write_demo(make_demo(), tmp_path / "episode0.h5")


@pytest.mark.parametrize("compression", ["gzip", "lzf"])
def test_everything_comes_back_bit_for_bit(tmp_path: Path, compression: str) -> None:
    """Arrays keep type, shape and bits; numbers, texts, lists and dicts of `misc` keep type and value."""
    demo = make_demo()
    again = read_demo(write_demo(demo, tmp_path / "e.h5", compression))  # type: ignore[arg-type]
    assert len(again) == len(demo)
    for before, after in zip(demo, again):
        assert_equal(dataclasses.asdict(before), dataclasses.asdict(after))
    assert_equal(demo.state, again.state)


def test_the_head_comes_back(episode: Path) -> None:
    """Seed, attempt, variation, instructions and versions survive."""
    demo, again = make_demo(), read_demo(episode)
    for name in ("random_seed", "num_reset_attempts", "variation_number", "instructions", "versions", "attempt", "task_name"):
        assert getattr(again, name) == getattr(demo, name)


def test_the_version_of_the_task_comes_back(tmp_path: Path) -> None:
    """From the file and from its manifest; an episode and an entry that do not record it are of version 1."""
    demo = make_demo()
    demo.task_version = 3
    path = DatasetWriter(tmp_path).add(demo)
    entry = read_manifest(tmp_path, "reach_target")[0]
    assert entry.task_version == read_demo(path).task_version == demo.with_observations(list(demo)).task_version == 3
    with Episode(path) as stored:
        assert stored.task_version == 3
    with h5py.File(path, "a") as file:
        del file.attrs["task_version"]
    older = tmp_path / "older.h5"
    shutil.move(path, older)
    assert read_demo(older).task_version == 1
    manifest = tmp_path / "reach_target" / "manifest.json"
    content = json.loads(manifest.read_text())
    del content["episodes"][0]["task_version"]
    manifest.write_text(json.dumps(content))
    assert read_manifest(tmp_path, "reach_target")[0].task_version == 1


def test_a_demo_without_extras_comes_back(tmp_path: Path) -> None:
    """Unknown seed and state stay unknown."""
    again = read_demo(write_demo(Demo([Observation(gripper_open=1.0)], task_name="x"), tmp_path / "e.h5"))
    assert (again.random_seed, again.num_reset_attempts, again.state, len(again)) == (None, None, None, 1)
    assert again[0].front_rgb is None
    assert again[0].gripper_open == 1.0


def test_returned_arrays_belong_to_the_caller(episode: Path) -> None:
    """Changing one frame changes no other, also where the file stores a value once for all frames."""
    demo = read_demo(episode)
    demo[0].misc["front_camera_intrinsics"][0, 0] = 7.0
    assert demo[1].misc["front_camera_intrinsics"][0, 0] == -175.84


def test_fields_can_be_left_out(episode: Path) -> None:
    """Only the wanted fields are read."""
    demo = read_demo(episode, fields=["joint_positions"])
    assert demo[0].front_rgb is None
    assert demo[0].joint_positions is not None


def test_the_same_demo_makes_the_same_bytes(tmp_path: Path) -> None:
    """No time stamp or chance gets into the file."""
    a, b = (write_demo(make_demo(), tmp_path / name) for name in ("a.h5", "b.h5"))
    assert a.read_bytes() == b.read_bytes()


def test_pictures_are_compressed(tmp_path: Path) -> None:
    """A plain image takes a small part of its raw size."""
    rgb = np.zeros((128, 128, 3), dtype=np.uint8)
    frames = [Observation(front_rgb=rgb + i % 250, front_depth=np.full((128, 128), i, dtype=np.float32)) for i in range(20)]
    path = write_demo(Demo(frames, task_name="x"), tmp_path / "e.h5")
    assert path.stat().st_size < 0.1 * 20 * 128 * 128 * 7


def test_nothing_is_left_after_a_failure(tmp_path: Path) -> None:
    """A demo that cannot be stored leaves neither a file nor a part of one, and the error names key and type."""
    demo = Demo([Observation(misc={"thing": object()})], task_name="x")
    with pytest.raises(DatasetError, match="object cannot be stored"):
        write_demo(demo, tmp_path / "e.h5")
    assert list(tmp_path.iterdir()) == []


def test_an_empty_demo_is_refused(tmp_path: Path) -> None:
    """There is nothing to learn from no observations."""
    with pytest.raises(DatasetError, match="without observations"):
        write_demo(Demo([]), tmp_path / "e.h5")


@pytest.mark.parametrize("keep", [0.0, 0.1, 0.5, 0.9])
def test_a_truncated_file_is_named(episode: Path, keep: float) -> None:
    """A file that was cut off is an error with its name and the remedy."""
    data = episode.read_bytes()
    episode.write_bytes(data[: int(keep * len(data))])
    with pytest.raises(DatasetError, match=r"episode0\.h5.*truncated or damaged.*record it again"):
        read_demo(episode)


def test_a_damaged_block_is_named(episode: Path) -> None:
    """A frame count that does not fit the content is an error, not a short demo."""
    with h5py.File(episode, "a") as file:
        file.attrs["frames"] = 6
    with pytest.raises(DatasetError, match="5 values for 6 frames"):
        read_demo(episode)


def test_another_version_is_named(episode: Path) -> None:
    """A file of a later format is refused with both versions."""
    with h5py.File(episode, "a") as file:
        file.attrs["version"] = 99
    with pytest.raises(DatasetError, match=r"episode0\.h5.*version 99.*version 1"):
        read_demo(episode)


def test_another_kind_of_file_is_named(tmp_path: Path) -> None:
    """Any other HDF5 file is refused."""
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["x"] = 1
    with pytest.raises(DatasetError, match=r"other\.h5.*not an episode"):
        read_demo(tmp_path / "other.h5")


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    """A path that does not exist is an error of ours."""
    with pytest.raises(DatasetError, match=r"nowhere\.h5.*does not exist"):
        read_demo(tmp_path / "nowhere.h5")


def test_the_state_of_a_generator_is_stored_in_the_place_of_a_seed(tmp_path: Path) -> None:
    """It comes back as a tuple that numpy takes; the manifest lists no seed, and the dataset verifies."""
    state = np.random.RandomState(3).get_state()
    demo = Demo([Observation(joint_positions=np.zeros(7))], random_seed=state, task_name="reach_target")
    path = DatasetWriter(tmp_path).add(demo)
    with Episode(path) as stored:
        read = stored.demo()
    assert isinstance(read.random_seed, tuple) and read.seed is None
    read.restore_state()
    assert encode_demo(read) == path.read_bytes()
    verify_task(tmp_path, "reach_target", structure=True)


TASK = "reach_target"


def test_an_episode_is_read_as_far_as_it_is_used(tmp_path: Path) -> None:
    """Single frames and fields are those of the whole; a frame that is asked for reads no other image."""
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
        with pytest.raises(DatasetError, match="has no field 'joint_forces'"):
            episode.array("joint_forces")


def test_what_an_episode_has_not_is_no_damage(tmp_path: Path) -> None:
    """Fields, keys and frames that there are not are refused by name; nobody is told to delete the file."""
    path = fill(tmp_path, range(1), frames=6) / TASK / "variation0" / "episodes" / "episode0.h5"
    with Episode(path) as episode:
        for read in (episode.shape, episode.series, episode.array):
            with pytest.raises(DatasetError, match=r"has no field 'joint_forces'.*Stored fields: .*joint_positions") as caught:
                read("joint_forces")
            assert not isinstance(caught.value, EpisodeFileError)
            with pytest.raises(InvalidValue, match="field has to be a text"):
                read(3)
        with pytest.raises(InvalidValue, match="key has to be a text"):
            episode.misc(3)
        for frames in (range(7), range(-1, 2), range(0, 6, 2), [1, 2], 3):
            with pytest.raises(InvalidValue, match=r"frames has to be a range"):
                episode.series("joint_positions", frames)
        with pytest.raises(InvalidValue, match="fields has to be a list of names"):
            episode.demo(fields="front_rgb")


def test_a_frame_reads_few_other_pictures(tmp_path: Path) -> None:
    """Damaged images of four frames leave the others readable, so they were not read for them; their own are errors."""
    pictures = np.random.default_rng(0).integers(0, 256, (6, 48, 48, 3), dtype=np.uint8)
    path = write_demo(Demo([Observation(front_rgb=image) for image in pictures], task_name=TASK), tmp_path / "e.h5")
    with h5py.File(path, "r") as file:
        offset = file["observations/front_rgb"].id.get_chunk_info(1).byte_offset
    with open(path, "r+b") as raw:
        raw.seek(offset)
        raw.write(bytes(64))
    with Episode(path) as episode:
        for index in (0, 3):
            assert np.array_equal(episode[index].front_rgb, pictures[index])
        with pytest.raises(EpisodeFileError, match=r"e\.h5.*damaged"):
            episode[4]


@pytest.mark.parametrize("kind", [np.uint8, np.int32, np.float32])
@pytest.mark.parametrize("shape", [(128, 128, 3), (301, 77), (64, 16, 4)])
@pytest.mark.parametrize("frames", [2, 9])
def test_pictures_of_any_size_come_back_bit_by_bit(kind: type, shape: tuple[int, ...], frames: int, tmp_path: Path) -> None:
    """Rows and frames that fill no chunk are stored as well, and any HDF5 reader finds standard filters."""
    rng = np.random.default_rng(frames)
    pictures = (rng.normal(size=(frames, *shape)) * 100.0).astype(kind)
    pictures[1:, : shape[0] // 2] = pictures[0, : shape[0] // 2]
    path = write_demo(Demo([Observation(front_depth=image) for image in pictures], task_name=TASK), tmp_path / "e.h5")
    with h5py.File(path, "r") as file:
        dataset = file["observations/front_depth"]
        assert dataset.compression == "gzip" and dataset.dtype == kind
        assert np.array_equal(dataset[()], pictures)
    with Episode(path) as episode:
        assert np.array_equal(episode[1].front_depth, pictures[1])


def test_equal_values_of_other_types_stay_apart(tmp_path: Path) -> None:
    """1, True and 1.0, keys 1 and '1', 0.0 and -0.0, dicts in another order, lists and tuples: each as it was written."""
    values = [1, True, True, {1: "a"}, {1: "a"}, {"1": "a"}, {True: "a"}, {"a": 0.0}, {"a": -0.0}]
    values += [{"a": 1, "b": None}, {"b": None, "a": 1}, [1, 2], (1, 2), [1, [2, 3]], [1, [2, 3]], [1, [2, 4]], "text", "text"]
    with h5py.File(tmp_path / "series.h5", "w") as file:
        write_series(file, "values", values, "gzip")
        read = read_series(file["values"], None, len(values))
    assert [repr(value) for value in read] == [repr(value) for value in values]
