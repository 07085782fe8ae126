"""RLBench-style folders: what is written is what the format says, what is read is what was written, nothing is trusted."""

from __future__ import annotations

import os
import pickle
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from rlbench_pin.datasets import DatasetWriter, episode_files, read_demo
from rlbench_pin.datasets.formats.rlbench import (
    decode_depth,
    decode_mask,
    encode_depth,
    encode_mask,
    export_rlbench,
    folder_demos,
    folder_episodes,
    read_folder,
)
from rlbench_pin.datasets.formats.rlbench_pickle import PickledDemo, PickledObservation, dump
from rlbench_pin.errors import DatasetError, EpisodeFileError
from rlbench_pin.observation import Demo, Observation

TASK = "reach_target"


def make_demo(seed: int, frames: int = 4, variation: int = 0) -> Demo:
    """Return a demo with images of three kinds and everything that `misc` may hold."""
    rng = np.random.default_rng(seed)
    observations = [
        Observation(
            front_rgb=rng.integers(0, 256, (12, 16, 3), dtype=np.uint8),
            front_depth=rng.random((12, 16), dtype=np.float32),
            front_mask=rng.integers(0, 70_000, (12, 16), dtype=np.int32),
            wrist_rgb=rng.integers(0, 256, (12, 16, 3), dtype=np.uint8),
            joint_positions=rng.normal(size=7),
            gripper_open=1.0,
            gripper_matrix=rng.normal(size=(4, 4)),
            misc={
                "front_camera_intrinsics": np.diag([-20.0, -20.0, 1.0]),
                "front_camera_extrinsics": np.eye(4),
                "front_camera_near": 0.01,
                "front_camera_far": 4.5,
                "variation_index": variation,
                "joint_poses": [rng.normal(size=7) for _ in range(7)],
                "descriptions": ["reach the red ball"],
            },
        )
        for _ in range(frames)
    ]
    return Demo(
        observations, random_seed=seed, num_reset_attempts=2, variation_number=variation,
        instructions=["reach the red ball", "touch it"], task_name=TASK,
    )  # fmt: skip


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Eleven episodes of variation 0, one of variation 2."""
    folder = tmp_path_factory.mktemp("data")
    for seed in range(11):
        DatasetWriter(folder).add(make_demo(seed))
    DatasetWriter(folder).add(make_demo(20, frames=6, variation=2))
    return folder


def test_depth_in_metres_below_one_is_stored_between_the_planes(tmp_path: Path) -> None:
    """Depth in [m] is known by its key of `misc`, although no value is above 1."""
    demo = make_demo(3)
    metres = [np.asarray(obs.front_depth) for obs in demo]
    for obs in demo:
        obs.misc["front_camera_depth_in_meters"] = True
    DatasetWriter(tmp_path / "data").add(demo)
    folders = export_rlbench(tmp_path / "data", tmp_path / "folders")
    (read,) = folder_demos(folders, TASK, 1, -1, random_selection=False)
    for obs, depth in zip(read, metres, strict=True):
        assert np.allclose(obs.front_depth, (depth - 0.01).clip(0.0) / 4.49, atol=1e-6)
        assert "front_camera_depth_in_meters" not in obs.misc


@pytest.fixture(scope="module", params=["upstream", "peract"])
def folders(request: pytest.FixtureRequest, root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same in folders, in both layouts."""
    return export_rlbench(root, tmp_path_factory.mktemp("folders") / request.param, layout=request.param)


def check_equal(read: Demo, original: Demo) -> None:
    """The same within the encodings: colours and ids exactly, depth within half a step of 24 bits."""
    assert len(read) == len(original)
    for a, b in zip(read, original):
        for name in ("front_rgb", "front_mask", "wrist_rgb", "joint_positions", "gripper_matrix"):
            assert np.array_equal(getattr(a, name), getattr(b, name))
        assert a.front_mask is not None
        assert a.front_mask.dtype == np.int32
        assert np.abs(np.subtract(a.front_depth, b.front_depth, dtype=np.float64)).max() < 1.2e-7
        assert (a.gripper_open, a.overhead_rgb, a.wrist_depth) == (1.0, None, None)
        assert a.misc.keys() == b.misc.keys()
        assert np.array_equal(a.misc["joint_poses"], b.misc["joint_poses"])
        assert np.array_equal(a.misc["front_camera_intrinsics"], b.misc["front_camera_intrinsics"])
    for name in ("random_seed", "num_reset_attempts", "variation_number", "instructions", "task_name"):
        assert getattr(read, name) == getattr(original, name)


@pytest.mark.simulation
def test_what_is_read_is_what_was_written(root: Path, folders: Path) -> None:
    """Every episode comes back equal within the encodings, in natural order, with seed, variation and sentences."""
    originals = [read_demo(path) for path in episode_files(root, TASK)]
    demos = folder_demos(folders, TASK, -1, -1, random_selection=False)
    for read, original in zip(demos, originals, strict=True):
        check_equal(read, original)
    assert [d.random_seed for d in folder_demos(folders, TASK, 1, 2, random_selection=False)] == [20]
    assert [d.random_seed for d in folder_demos(folders, TASK, 2, 0, random_selection=False, from_episode_number=9)] == [9, 10]
    drawn = folder_demos(folders, TASK, 5, 0, rng=np.random.default_rng(0))
    assert len({d.random_seed for d in drawn}) == 5


@pytest.mark.simulation
def test_the_layouts_are_those_of_the_format(root: Path, tmp_path: Path) -> None:
    """Folders and files are where loaders of either dialect look for them."""
    upstream = export_rlbench(root, tmp_path / "upstream") / TASK
    peract = export_rlbench(root, tmp_path / "peract", layout="peract") / TASK
    assert (upstream / "variation2" / "variation_descriptions.pkl").is_file()
    episode = upstream / "variation0" / "episodes" / "episode10"
    assert {p.name for p in episode.iterdir()} == {"low_dim_obs.pkl", "front_rgb", "front_depth", "front_mask", "wrist_rgb"}
    assert sorted(p.name for p in (episode / "front_rgb").iterdir()) == ["0.png", "1.png", "2.png", "3.png"]
    episodes = peract / "all_variations" / "episodes"
    assert len(list(episodes.iterdir())) == 12
    assert pickle.loads((episodes / "episode11" / "variation_number.pkl").read_bytes()) == 2
    assert pickle.loads((episodes / "episode11" / "variation_descriptions.pkl").read_bytes()) == [
        "reach the red ball",
        "touch it",
    ]


def test_the_pictures_are_those_of_the_format(root: Path, tmp_path: Path) -> None:
    """Depth has its high byte in red, masks their low byte in red."""
    demo = read_demo(episode_files(root, TASK)[3])
    episode = export_rlbench(root, tmp_path / "x") / TASK / "variation0" / "episodes" / "episode3"
    rgb, depth, mask = (np.asarray(Image.open(episode / f"front_{p}" / "2.png")).astype(int) for p in ("rgb", "depth", "mask"))
    assert np.array_equal(rgb, demo[2].front_rgb)
    steps = depth[..., 0] * 65536 + depth[..., 1] * 256 + depth[..., 2]
    assert np.abs(steps / (2**24 - 1) - demo[2].front_depth).max() < 6e-8
    assert np.array_equal(mask[..., 0] + 256 * mask[..., 1] + 65536 * mask[..., 2], demo[2].front_mask)


def test_depth_survives_to_half_a_micrometre() -> None:
    """Every depth within 4.5 m comes back within half a micrometre, ends included; masks exactly."""
    depth = np.append(np.random.default_rng(0).random(1000), [0.0, 1.0]).astype(np.float32).reshape(2, -1)
    assert np.abs(decode_depth(encode_depth(depth)).astype(float) - depth).max() * 4.5 < 5e-7
    mask = np.array([[0, 1, 255, 256, 65535, 65536, 2**24 - 1]], dtype=np.int32)
    assert np.array_equal(decode_mask(encode_mask(mask)), mask)
    with pytest.raises(DatasetError, match=r"0\.\.1"):
        encode_depth(np.array([[1.5]]))
    with pytest.raises(DatasetError, match="2\\^24"):
        encode_mask(np.array([[2**24]]))


@pytest.mark.simulation
def test_broken_folders_are_named(root: Path, tmp_path: Path) -> None:
    """An image too few, a damaged image and a missing list are errors with a path; masks are not counted."""
    folders = export_rlbench(root, tmp_path / "x")
    episodes = folder_episodes(folders, TASK, 0)
    (episodes[0] / "front_rgb" / "3.png").unlink()
    with pytest.raises(RuntimeError, match=r"Broken dataset.*front_rgb.*3 images for 4 frames"):
        read_folder(episodes[0])
    (episodes[1] / "wrist_rgb" / "1.png").write_bytes(b"\x89PNG nothing")
    with pytest.raises(EpisodeFileError, match=r"1\.png.*damaged"):
        read_folder(episodes[1])
    assert read_folder(episodes[1], fields=["front_rgb"])[0].wrist_rgb is None
    (episodes[2] / "low_dim_obs.pkl").write_bytes(dump("nothing of the kind"))
    with pytest.raises(EpisodeFileError, match="no list of observations"):
        read_folder(episodes[2])
    with pytest.raises(DatasetError, match="13 demos"):
        folder_demos(folders, TASK, 13, -1, random_selection=False)


def test_old_episodes_are_read(tmp_path: Path) -> None:
    """Old files lack the variation in `misc` and may have an observation where the sentences belong."""
    folder = tmp_path / TASK / "variation3" / "episodes" / "episode0"
    folder.mkdir(parents=True)
    demo, observation = PickledDemo(), PickledObservation()
    observation.__dict__.update(joint_positions=np.zeros(7), misc={})
    demo.__dict__.update(_observations=[observation, observation], random_seed=None)
    (folder / "low_dim_obs.pkl").write_bytes(dump(demo))
    (folder.parents[1] / "variation_descriptions.pkl").write_bytes(dump(observation))
    (read,) = folder_demos(tmp_path, TASK, -1, 3, random_selection=False)
    assert (read.variation_number, read.instructions, len(read)) == (3, (), 2)
    assert read[1].misc["variation_index"] == 3


def test_paths_instead_of_pictures(root: Path, tmp_path: Path) -> None:
    """With `image_paths`, image fields hold the paths of files that any program opens."""
    folders = export_rlbench(root, tmp_path / "x")
    (demo,) = folder_demos(folders, TASK, 1, 0, image_paths=True, random_selection=False)
    assert str(demo[2].front_rgb).endswith(os.path.join("episode0", "front_rgb", "2.png"))
    with Image.open(str(demo[2].front_rgb)) as picture:
        assert picture.size == (16, 12)


def test_the_state_of_a_generator_is_read_in_the_place_of_a_seed(tmp_path: Path) -> None:
    """As the upstream generator writes it; numpy takes it back."""
    demo = make_demo(1)
    demo.random_seed = np.random.RandomState(3).get_state()
    DatasetWriter(tmp_path / "data").add(demo)
    folders = export_rlbench(tmp_path / "data", tmp_path / "folders")
    read = folder_demos(folders, TASK, 1, 0, random_selection=False)[0]
    assert isinstance(read.random_seed, tuple)
    read.restore_state()
    assert np.random.random() == np.random.RandomState(3).random()  # noqa: NPY002
