"""Frames with the actions that follow them, as a map-style dataset that worker processes share."""

from __future__ import annotations

import multiprocessing
import pickle
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.datasets import DatasetWriter, FrameDataset, key_frame_actions, key_frames, read_demo
from rlbench_pin.errors import DatasetError, DemoError, EpisodeFileError, InvalidValue
from rlbench_pin.observation import Demo, Observation

LENGTHS = (5, 9, 7)


def moving_demo(frames: int, seed: int, task: str = "reach_target") -> Demo:
    """A demonstration whose hand closes in the middle."""
    rng = np.random.default_rng(seed)
    observations = [
        Observation(
            front_rgb=rng.integers(0, 256, (48, 48, 3), dtype=np.uint8),
            joint_positions=rng.normal(size=7),
            joint_velocities=np.ones(7),
            gripper_open=float(i < frames // 2),
            gripper_pose=rng.normal(size=7),
            misc={"joint_position_action": np.append(rng.normal(size=7), 1.0)} if i else {},
        )
        for i in range(frames)
    ]
    for observation in observations:
        observation.ignore_collisions = False
    return Demo(observations, random_seed=seed, instructions=["reach the ball"], task_name=task)


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """Three episodes of different lengths."""
    for seed, frames in enumerate(LENGTHS):
        DatasetWriter(tmp_path / "data").add(moving_demo(frames, seed))
    return tmp_path / "data"


def demos(root: Path) -> list[Demo]:
    """The stored demonstrations."""
    return [read_demo(root / f"reach_target/variation0/episodes/episode{number}.h5") for number in range(len(LENGTHS))]


def same(a: np.ndarray, b: np.ndarray | None) -> bool:
    """Whether both are there and equal."""
    return b is not None and np.array_equal(a, b)


def test_a_sample_is_a_frame_and_the_actions_that_follow_it(root: Path) -> None:
    """All frames but the last of each episode; beyond the end the last action is repeated and marked."""
    dataset = FrameDataset(root, fields=("front_rgb", "joint_positions", "gripper_open"), horizon=3)
    expected = [(number, frame) for number, frames in enumerate(LENGTHS) for frame in range(frames - 1)]
    assert len(dataset) == len(expected)
    stored = demos(root)
    for index, (number, frame) in enumerate(expected):
        sample, demo = dataset[index], stored[number]
        assert (sample["episode"], sample["frame"], sample["instruction"]) == (number, frame, "reach the ball")
        assert same(sample["front_rgb"], demo[frame].front_rgb)
        assert same(sample["joint_positions"], demo[frame].joint_positions)
        assert sample["gripper_open"] == demo[frame].gripper_open
        last = len(demo) - 1
        following = [demo[min(frame + 1 + step, last)].misc["joint_position_action"] for step in range(3)]
        assert np.array_equal(sample["action"], following)
        assert sample["action_is_pad"].tolist() == [frame + 1 + step > last for step in range(3)]
    assert np.array_equal(dataset[-1]["front_rgb"], dataset[len(dataset) - 1]["front_rgb"])


def test_a_loop_over_a_dataset_ends(root: Path) -> None:
    """As over a list; an index beyond is an IndexError, no index an InvalidValue."""
    dataset = FrameDataset(root, fields=())
    assert [sample["frame"] for sample in dataset] == [*range(4), *range(8), *range(6)]  # type: ignore[attr-defined]
    for index in (len(dataset), -len(dataset) - 1):
        with pytest.raises(IndexError, match="the dataset has 18"):
            dataset[index]
    with pytest.raises(InvalidValue, match="index has to be a whole number"):
        dataset[0.5]  # type: ignore[index]
    assert dataset[np.int64(3)]["frame"] == 3  # type: ignore[index]


def test_key_frames_lead_to_key_frames(root: Path) -> None:
    """One sample before each key frame, with the actions of that one and those after it."""
    dataset, stored = FrameDataset(root, fields=("front_rgb",), horizon=2, key_frames_only=True), demos(root)
    moments = [(number, [0, *key_frames(demo)]) for number, demo in enumerate(stored)]
    expected = [(number, frame) for number, frames in moments for frame in frames[:-1]]
    assert [(dataset[i]["episode"], dataset[i]["frame"]) for i in range(len(dataset))] == expected
    first, second = key_frame_actions(stored[0])[:2]
    assert np.array_equal(dataset[0]["action"], [first, second])
    assert same(dataset[0]["front_rgb"], stored[0][0].front_rgb)
    assert same(dataset[1]["front_rgb"], stored[0][key_frames(stored[0])[0]].front_rgb)


def samples_of(dataset: FrameDataset, indices: range) -> list[bytes]:
    """Read some samples, in any process."""
    return [b"".join(np.asarray(dataset[i][name]).tobytes() for name in ("front_rgb", "action")) for i in indices]


@pytest.mark.simulation
@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_worker_processes_read_the_same(root: Path, method: str) -> None:
    """Processes get a dataset that was used before, by fork or by pickle, and open files of their own."""
    dataset = FrameDataset(root)
    everything = range(len(dataset))
    expected = samples_of(dataset, everything)
    assert samples_of(pickle.loads(pickle.dumps(dataset)), everything) == expected
    with multiprocessing.get_context(method).Pool(2) as pool:
        for found in pool.starmap(samples_of, [(dataset, everything)] * 4, chunksize=1):
            assert found == expected
    assert samples_of(dataset, everything) == expected


class Inherited:
    """A dataset that a forked process has from its parent, as the workers of a DataLoader do."""

    dataset: FrameDataset

    @classmethod
    def read(cls, index: int) -> list[bytes]:
        """Read one sample."""
        return samples_of(cls.dataset, range(index, index + 1))


@pytest.mark.simulation
def test_forked_workers_do_not_share_files(root: Path) -> None:
    """Several that read at once what their parent had opened get what it reads."""
    Inherited.dataset = FrameDataset(root)
    expected = samples_of(Inherited.dataset, range(18))
    with multiprocessing.get_context("fork").Pool(4) as pool:
        for _ in range(20):
            assert sum(pool.map(Inherited.read, range(18), chunksize=1), []) == expected


def test_more_episodes_than_files_stay_open(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Those that were closed are opened again."""
    monkeypatch.setattr("rlbench_pin.datasets.frames._OPEN_FILES", 1)
    dataset = FrameDataset(root)
    assert [dataset[i]["episode"] for i in (0, 17, 1, 5, 0)] == [0, 2, 0, 1, 0]


def test_what_is_missing_is_named(root: Path, tmp_path: Path) -> None:
    """A field, a task, actions, a file; and a file that was altered."""
    with pytest.raises(DatasetError, match=r"has no field 'wrist_rgb'.*front_rgb"):
        FrameDataset(root, fields=("wrist_rgb",))
    with pytest.raises(DatasetError, match="reach_targt"):
        FrameDataset(root, ("reach_targt",))
    with pytest.raises(DatasetError, match="does not exist"):
        FrameDataset(tmp_path / "nothing")
    with pytest.raises(InvalidValue, match="horizon"):
        FrameDataset(root, horizon=0)
    with pytest.raises(InvalidValue, match="horizon"):
        FrameDataset(root, horizon=2**31)
    bare = moving_demo(4, 9)
    for observation in bare:
        observation.misc.clear()
        del observation.ignore_collisions
    DatasetWriter(tmp_path / "bare").add(bare)
    with pytest.raises(DatasetError, match="joint_position_action"):
        FrameDataset(tmp_path / "bare")
    with pytest.raises(DemoError, match="ignore_collisions"):
        FrameDataset(tmp_path / "bare", key_frames_only=True)
    dataset = FrameDataset(root)
    path = root / "reach_target/variation0/episodes/episode2.h5"
    path.write_bytes(path.read_bytes()[:-1] + b"x")
    with pytest.raises(EpisodeFileError, match=r"episode2\.h5.*SHA-256"):
        dataset[-1]
    path.unlink()
    with pytest.raises(EpisodeFileError, match=r"episode2\.h5.*does not exist"):
        dataset[-1]


def test_a_data_loader_takes_it(root: Path) -> None:
    """With and without workers: batches of tensors, and lists of sentences."""
    data = pytest.importorskip("torch.utils.data")
    for workers in (0, 2):
        loader = data.DataLoader(FrameDataset(root, horizon=2), batch_size=6, num_workers=workers)
        batches = list(loader)
        assert [tuple(batch["front_rgb"].shape) for batch in batches] == [(6, 48, 48, 3)] * 3
        assert tuple(batches[0]["action"].shape) == (6, 2, 8)
        assert batches[0]["instruction"] == ["reach the ball"] * 6
