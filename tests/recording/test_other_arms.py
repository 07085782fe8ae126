"""Demonstrations of another arm: recorded, listed, replayed, rendered again and exported under its name."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from rlbench_pin.cli.main import main
from rlbench_pin.datasets import Episode, episode_files, read_demo, read_manifest
from rlbench_pin.datasets.formats.lerobot import export_lerobot
from rlbench_pin.datasets.formats.robomimic import export_robomimic
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.errors import DatasetConflict, DatasetError, TaskEnvironmentError
from rlbench_pin.processes import SerialEngine
from rlbench_pin.recording.config import ImageConfig, RecordConfig, read_recording
from rlbench_pin.recording.record import record
from rlbench_pin.recording.replay import replay_stored
from rlbench_pin.recording.rerender import rerender
from rlbench_pin.robot import SUPPORTED_ROBOTS, UnknownRobot

ROBOT, TASK = "ur5e", "reach_target"
CONFIG = RecordConfig(tasks=(TASK,), episodes=1, robot="UR5e", images=ImageConfig(products=()))


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A dataset of one episode."""
    root = tmp_path_factory.mktemp("arms")
    assert record(CONFIG, root, engine=SerialEngine()).missing == 0
    return root


@pytest.mark.simulation
def test_the_arm_is_recorded(recorded: Path) -> None:
    """In the settings, the manifest, the file and the demonstration; its joints by their names."""
    (path,) = episode_files(recorded, TASK)
    joints = SUPPORTED_ROBOTS[ROBOT].arm_joints
    assert read_recording(recorded).robot == read_manifest(recorded, TASK)[0].robot == ROBOT
    with Episode(path) as episode:
        assert (episode.robot, episode.joint_names) == (ROBOT, joints)
    demo = read_demo(path)
    assert (demo.robot, demo.joint_names) == (ROBOT, joints)
    assert demo[0].joint_positions is not None and demo[0].joint_positions.shape == (6,)


@pytest.mark.simulation
def test_it_is_played_by_that_arm(recorded: Path, tmp_path: Path) -> None:
    """Replayed, and made again with images, with the arm that it names; another arm refuses its start."""
    assert [result.reached for result in replay_stored([recorded])] == [True]
    small = ImageConfig(cameras=("front",), products=("rgb",), image_size=(32, 32))
    assert rerender(recorded, tmp_path / "images", small, engine=SerialEngine()).missing == 0
    assert read_manifest(tmp_path / "images", TASK)[0].robot == ROBOT
    demo = read_demo(episode_files(recorded, TASK)[0])
    with make_environment(low_dim_config()) as environment, pytest.raises(TaskEnvironmentError, match="robot_setup='ur5e'"):
        environment.get_task(TASK).reset_to_demo(demo)


@pytest.mark.simulation
def test_exports_carry_its_joint_names(recorded: Path, tmp_path: Path) -> None:
    """LeRobot names the arm and its joints; robomimic makes an environment with it."""
    import h5py

    info = json.loads((export_lerobot(recorded, tmp_path / "lerobot") / "meta" / "info.json").read_text())
    assert info["robot_type"] == ROBOT
    assert info["features"]["action"]["names"] == [*SUPPORTED_ROBOTS[ROBOT].arm_joints, "gripper"]
    with h5py.File(export_robomimic(recorded, tmp_path / "one.hdf5")) as file:
        assert json.loads(file["data"].attrs["env_args"])["env_kwargs"] == {"robot": ROBOT}


@pytest.mark.simulation
def test_paired_arms_share_seeds_and_attempts(tmp_path: Path) -> None:
    """Two datasets of the same episodes; an attempt that one arm cannot do counts for none."""
    command = ["record", "pick_and_lift", "--paired", "panda,jaco", "--episodes", "3", "--products", "--workers", "0"]
    assert main([*command, "--out", str(tmp_path)]) == 0
    entries = {robot: read_manifest(tmp_path / robot, "pick_and_lift") for robot in ("panda", "jaco")}
    episodes = {robot: [(e.variation, e.episode, e.random_seed, e.attempt) for e in found] for robot, found in entries.items()}
    assert episodes["panda"] == episodes["jaco"]
    assert {robot: {entry.robot for entry in found} for robot, found in entries.items()} == {"panda": {"panda"}, "jaco": {"jaco"}}
    assert read_recording(tmp_path / "jaco").paired == ("panda",)
    assert main(["record", "--resume", "--out", str(tmp_path / "jaco")]) == 0


@pytest.mark.simulation
def test_arms_are_not_mixed(recorded: Path, tmp_path: Path) -> None:
    """A folder has one arm; an export of two is refused; an unknown arm is refused before anything is made."""
    other = RecordConfig(tasks=(TASK,), episodes=1, images=ImageConfig(products=()))
    with pytest.raises(DatasetConflict, match=r"--robot ur5e"):
        record(other, recorded, engine=SerialEngine(), resume=True)
    both = tmp_path / "both"
    record(replace(other, tasks=("push_button",)), both, engine=SerialEngine())
    shutil.copytree(recorded / TASK, both / TASK)
    with pytest.raises(DatasetError, match="those before it with 'panda'"):
        export_lerobot(both, tmp_path / "out")
    with pytest.raises(UnknownRobot, match="sawyer"):
        RecordConfig(tasks=(TASK,), robot="sawyer")
