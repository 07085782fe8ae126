"""An open episode reads what it is asked for and nothing else."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from rlbench_pin.datasets import (
    Episode,
    read_demo,
    write_demo,
)
from rlbench_pin.errors import DatasetError, EpisodeFileError, InvalidValue
from rlbench_pin.observation import Demo, Observation
from tests.demos_for_tests import fill, make_demo

TASK = "reach_target"


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


def test_what_an_episode_has_not_is_no_damage(tmp_path: Path) -> None:
    """Fields, keys and frames that there are not are refused by name; nobody is told to delete the file."""
    path = fill(tmp_path, range(1), frames=6) / TASK / "variation0" / "episodes" / "episode0.h5"
    with Episode(path) as episode:
        for read in (episode.shape, episode.series, episode.array):
            with pytest.raises(DatasetError, match=r"does not hold 'joint_forces'.*It holds .*joint_positions") as caught:
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
    """Damaged pictures of four frames leave the others readable, so they were not read for them; their own are errors."""
    pictures = np.random.default_rng(0).integers(0, 256, (6, 48, 48, 3), dtype=np.uint8)
    path = write_demo(Demo([Observation(front_rgb=picture) for picture in pictures], task_name=TASK), tmp_path / "e.h5")
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
    path = write_demo(Demo([Observation(front_depth=picture) for picture in pictures], task_name=TASK), tmp_path / "e.h5")
    with h5py.File(path, "r") as file:
        dataset = file["observations/front_depth"]
        assert dataset.compression == "gzip" and dataset.dtype == kind
        assert np.array_equal(dataset[()], pictures)
    with Episode(path) as episode:
        assert np.array_equal(episode[1].front_depth, pictures[1])
