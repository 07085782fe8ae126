"""Exports hold what was recorded, in the structure that their readers document, and the real readers load them.

The real readers want numpy versions of their own, so they may live in another Python: `RLBENCH_PIN_LEROBOT_PYTHON` and
`RLBENCH_PIN_ROBOMIMIC_PYTHON` name it.
"""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import av
import h5py
import numpy as np
import pytest

from rlbench_pin.cli.main import main
from rlbench_pin.datasets import DatasetWriter, episode_files, read_demo
from rlbench_pin.datasets.formats import find_exporter
from rlbench_pin.errors import DatasetConflict, DatasetError, EpisodeFileError, MissingExtra
from rlbench_pin.observation import Demo, Observation

READERS = Path(__file__).parent / "readers"
LENGTHS = (7, 5, 9)
SIZE = 32


def make_demo(seed: int, frames: int, task: str = "reach_target") -> Demo:
    """Return a demo with smooth images, joints and the actions that lead from frame to frame."""
    rng = np.random.default_rng(seed)
    joints = np.cumsum(rng.normal(size=(frames, 7), scale=0.05), axis=0)
    observations = []
    for t in range(frames):
        y, x = np.indices((SIZE, SIZE)) * 255 // (SIZE - 1)
        observation = Observation(
            front_rgb=np.stack([x, y, np.full_like(x, 20 * t)], axis=-1).astype(np.uint8),
            front_depth=(x / 255).astype(np.float32),
            wrist_rgb=np.full((SIZE, SIZE, 3), 10 * t + seed, dtype=np.uint8),
            joint_positions=joints[t],
            joint_velocities=rng.normal(size=7),
            gripper_open=float(t < frames // 2),
            gripper_pose=rng.normal(size=7),
            task_low_dim_state=np.zeros(0),
        )
        if t:
            observation.misc["joint_position_action"] = np.append(joints[t] + 0.01, float(t < frames // 2))
        observations.append(observation)
    text = ["reach the red ball", "touch the red ball"] if seed % 2 == 0 else ["reach the blue ball"]
    return Demo(observations, random_seed=seed, variation_number=seed % 2, instructions=text, task_name=task)


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three episodes of two variations."""
    folder = tmp_path_factory.mktemp("exported")
    for seed, frames in enumerate(LENGTHS):
        DatasetWriter(folder).add(make_demo(seed, frames))
    return folder


@pytest.fixture(scope="module")
def demos(root: Path) -> list[Demo]:
    """The same, in the order of the manifest."""
    return [read_demo(path) for path in episode_files(root, "reach_target")]


def _python_with(library: str) -> str:
    """Return a Python that has a library, or skip."""
    named = os.environ.get(f"RLBENCH_PIN_{library.upper()}_PYTHON", "")
    if named:
        return named
    if importlib.util.find_spec(library) is None:
        pytest.skip(f"'{library}' is not installed, and RLBENCH_PIN_{library.upper()}_PYTHON names no Python that has it")
    return sys.executable


def _output_of(library: str, path: Path) -> dict[str, Any]:
    command = [_python_with(library), str(READERS / f"read_{library}.py"), str(path)]
    environment = {**os.environ, "HF_HUB_OFFLINE": "1", "HF_DATASETS_CACHE": str(path.parent / "cache")}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    found: dict[str, Any] = json.loads(done.stdout[done.stdout.index("{") :])
    return found


def _stacked(demos: list[Demo]) -> tuple[np.ndarray, np.ndarray]:
    """States and actions of all frames, the last action of an episode repeated."""
    states = [np.append(o.joint_positions, o.gripper_open) for demo in demos for o in demo]
    actions = [o.misc["joint_position_action"] for demo in demos for o in [*demo[1:], demo[-1]]]
    return np.array(states), np.array(actions)


# LeRobot --------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def lerobot(root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A LeRobotDataset."""
    pytest.importorskip("pyarrow")
    out: Path = find_exporter("lerobot")(root, tmp_path_factory.mktemp("lerobot") / "data")
    return out


@pytest.mark.simulation
def test_lerobot_structure(lerobot: Path, demos: list[Demo]) -> None:
    """Frames, episodes, sentences and images stand where version 3.0 says; nothing else is written."""
    from pyarrow import parquet

    info = json.loads((lerobot / "meta" / "info.json").read_text())
    assert (info["codebase_version"], info["fps"]) == ("v3.0", 20)
    assert (info["total_episodes"], info["total_frames"], info["total_tasks"]) == (3, 21, 2)
    frames = parquet.read_table(lerobot / info["data_path"].format(chunk_index=0, file_index=0)).to_pydict()
    states, actions = _stacked(demos)
    assert np.array_equal(np.array(frames["observation.state"], dtype=np.float32), states.astype(np.float32))
    assert np.array_equal(np.array(frames["action"], dtype=np.float32), actions.astype(np.float32))
    assert frames["index"] == list(range(21))
    assert sum(frames["next.done"]) == 3
    assert np.allclose(frames["timestamp"], np.array(frames["frame_index"]) / 20)
    episodes = parquet.read_table(lerobot / "meta/episodes/chunk-000/file-000.parquet").to_pylist()
    assert [(e["dataset_from_index"], e["dataset_to_index"]) for e in episodes] == [(0, 7), (7, 16), (16, 21)]
    assert [e["tasks"] for e in episodes] == [["reach the red ball"], ["reach the red ball"], ["reach the blue ball"]]
    statistics = json.loads((lerobot / "meta" / "stats.json").read_text())
    assert np.allclose(statistics["observation.state"]["mean"], states.mean(0), atol=1e-6)
    assert np.shape(statistics["observation.images.front"]["std"]) == (3, 1, 1)
    assert {"data", "meta", "videos"} == {path.name for path in lerobot.iterdir()}


def test_lerobot_pictures(lerobot: Path, demos: list[Demo]) -> None:
    """Each episode's images are found at its time stamps and look like the originals."""
    for camera in ("front", "wrist"):
        with av.open(str(lerobot / f"videos/observation.images.{camera}/chunk-000/file-000.mp4")) as container:
            stream = container.streams.video[0]
            decoded = [(frame.time, frame.to_ndarray(format="rgb24")) for frame in container.decode(stream)]
        originals = [getattr(o, f"{camera}_rgb") for demo in demos for o in demo]
        assert np.allclose([time for time, _ in decoded], np.arange(21) / 20)
        errors = [
            np.abs(picture.astype(int) - original).mean() for (_, picture), original in zip(decoded, originals, strict=True)
        ]
        assert max(errors) < 6.0


@pytest.mark.slow
def test_lerobot_loads_it(lerobot: Path, demos: list[Demo]) -> None:
    """The dataset class of `lerobot` iterates over all frames, with images, state, action and task."""
    found = _output_of("lerobot", lerobot)
    states, actions = _stacked(demos)
    assert (found["frames"], found["episodes"], found["fps"], found["window"]) == (21, 3, 20, [3, 8])
    assert found["tasks"] == ["reach the blue ball", "reach the red ball"]
    assert found["cameras"] == ["observation.images.wrist", "observation.images.front"]
    assert found["picture"] == [3, SIZE, SIZE]
    assert np.allclose(found["state"], states, atol=1e-6)
    assert np.allclose(found["action"], actions, atol=1e-6)
    assert np.allclose(found["mean"], states.mean(0), atol=1e-6)
    for camera, seen in zip(("wrist", "front"), found["brightness"], strict=True):
        assert np.allclose(seen, [getattr(o, f"{camera}_rgb").mean() / 255 for demo in demos for o in demo], atol=0.02)


# robomimic ------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def robomimic(root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A robomimic file."""
    out: Path = find_exporter("robomimic")(root, tmp_path_factory.mktemp("robomimic") / "data.hdf5")
    return out


def test_robomimic_structure(robomimic: Path, demos: list[Demo]) -> None:
    """Groups, attributes and masks are those that robomimic documents; actions scale back to those recorded."""
    with h5py.File(robomimic, "r") as file:
        data = file["data"]
        assert json.loads(data.attrs["env_args"])["env_name"] == "rlbench_pin/reach_target-state-v0"
        assert data.attrs["total"] == sum(LENGTHS) - 3
        assert [name.decode() for name in file["mask/train"]] == ["demo_0", "demo_1", "demo_2"]
        low, high = data.attrs["action_low"], data.attrs["action_high"]
        for index, demo in enumerate(demos):
            group = data[f"demo_{index}"]
            assert group.attrs["num_samples"] == len(demo) - 1
            assert np.abs(group["actions"][()]).max() <= 1.0
            commands = np.array([o.misc["joint_position_action"] for o in demo[1:]])
            assert np.array_equal(group["actions_abs"][()], commands)
            assert np.allclose(low + (group["actions"][()] + 1) / 2 * (high - low), commands)
            joints = np.array([o.joint_positions for o in demo])
            assert np.array_equal(group["obs/joint_positions"][()], joints[:-1])
            assert np.array_equal(group["next_obs/joint_positions"][()], joints[1:])
            assert np.array_equal(group["obs/front_image"][()], [o.front_rgb for o in demo[:-1]])
            assert group["obs/front_depth"].shape == (len(demo) - 1, SIZE, SIZE, 1)
            assert list(group["dones"]) == [0] * (len(demo) - 2) + [1]


@pytest.mark.slow
def test_robomimic_loads_it(robomimic: Path, demos: list[Demo]) -> None:
    """The dataset class of robomimic reads sequences from it."""
    found = _output_of("robomimic", robomimic)
    assert found["environment"]["env_name"] == "rlbench_pin/reach_target-state-v0"
    assert found["shapes"]["front_image"] == [3, SIZE, SIZE]
    assert (found["steps"], found["actions"]) == (sum(LENGTHS) - 3, [10, 8])
    assert np.allclose(found["joints"], demos[0][0].joint_positions)
    assert np.allclose(found["next_joints"], demos[0][1].joint_positions)
    assert found["rewards"] == 3.0


# Zarr -----------------------------------------------------------------------------------------------------------------


def test_zarr_reads_it(root: Path, demos: list[Demo], tmp_path: Path) -> None:
    """All frames in a row, split where the episodes end; images without loss."""
    zarr = pytest.importorskip("zarr")
    group = zarr.open_group(str(find_exporter("zarr", ("front",))(root, tmp_path / "data.zarr")), mode="r")
    states, actions = _stacked(demos)
    assert list(group["meta/episode_ends"][:]) == [7, 16, 21]
    assert list(group["meta/task_index"][:]) == [0, 0, 1]
    assert np.array_equal(group["data/state"][:], states.astype(np.float32))
    assert np.array_equal(group["data/action"][:], actions.astype(np.float32))
    assert np.array_equal(group["data/front_rgb"][:], [o.front_rgb for demo in demos for o in demo])
    assert "wrist_rgb" not in group["data"]


# All of them ----------------------------------------------------------------------------------------------------------

FORMATS = ("lerobot", "robomimic", "rlbench", "peract", "zarr")


def _exporter(name: str) -> Callable[..., Path]:
    try:
        return find_exporter(name)  # type: ignore[arg-type]
    except MissingExtra as error:
        pytest.skip(str(error))


@pytest.mark.parametrize("name", FORMATS)
def test_an_export_replaces_nothing(root: Path, tmp_path: Path, name: str) -> None:
    """What exists stays as it is."""
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "precious").write_text("x")
    with pytest.raises(DatasetConflict, match="exists"):
        _exporter(name)(root, tmp_path / "there")
    assert [path.name for path in tmp_path.rglob("*")] == ["there", "precious"]


@pytest.mark.parametrize("name", FORMATS)
def test_an_export_of_a_damaged_dataset_leaves_nothing(tmp_path: Path, name: str) -> None:
    """The bad file is named, and neither a folder nor a part of one is left."""
    data = tmp_path / "data"
    for seed in range(2):
        DatasetWriter(data).add(make_demo(2 * seed, 4))
    path = episode_files(data, "reach_target")[1]
    damaged = bytearray(path.read_bytes())
    damaged[-3] ^= 4
    path.write_bytes(bytes(damaged))
    with pytest.raises(EpisodeFileError, match=r"episode1\.h5"):
        _exporter(name)(data, tmp_path / "out")
    assert [p.name for p in tmp_path.iterdir()] == ["data"]


@pytest.mark.parametrize("name", ["lerobot", "robomimic", "zarr"])
def test_cameras_that_are_not_stored_are_named(root: Path, tmp_path: Path, name: str) -> None:
    """So are tasks."""
    _exporter(name)
    with pytest.raises(DatasetError, match=r"no colour images of \['overhead'\]"):
        find_exporter(name, ("overhead",))(root, tmp_path / "out")  # type: ignore[arg-type]
    with pytest.raises(DatasetError, match=r"no task 'push_button', only \['reach_target'\].*rlbench-pin record"):
        _exporter(name)(root, tmp_path / "out", tasks=("push_button",))
    with pytest.raises(DatasetError, match="Did you mean 'reach_target'"):
        _exporter(name)(root, tmp_path / "out", tasks=("reach_targt",))


def test_a_missing_library_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the extra, the error says which one to install."""
    monkeypatch.setitem(sys.modules, "rlbench_pin.datasets.formats.lerobot", None)
    with pytest.raises(MissingExtra, match=r"pip install -e '\.\[lerobot\]'"):
        find_exporter("lerobot")


def test_the_command_exports(root: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`dataset export FORMAT ROOT OUT` writes and says where."""
    out = tmp_path / "data.hdf5"
    assert main(["dataset", "export", "robomimic", str(root), str(out), "--cameras", "front"]) == 0
    assert f"3 episodes in {out}" in capsys.readouterr().out
    with h5py.File(out, "r") as file:
        assert "wrist_image" not in file["data/demo_0/obs"]
    DatasetWriter(tmp_path / "two").add(make_demo(0, 4))
    DatasetWriter(tmp_path / "two").add(make_demo(0, 4, task="push_button"))
    assert main(["dataset", "export", "robomimic", str(tmp_path / "two"), str(tmp_path / "x.hdf5")]) == 1
    assert "--tasks" in capsys.readouterr().err
