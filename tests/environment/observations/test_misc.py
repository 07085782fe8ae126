"""What `misc` holds beside the matrices of cameras: joint poses, descriptions, names of masks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.datasets import DatasetWriter, Episode
from rlbench_pin.datasets.writer import encode_demo, write_demo
from rlbench_pin.environment import CameraConfig, Environment, JointPositionActionMode, ObservationConfig
from rlbench_pin.observation import Demo, Observation
from rlbench_pin.recording.config import ImageConfig


def small_config(**settings: object) -> ObservationConfig:
    """No images but a small front camera's."""
    config = ObservationConfig(**settings)  # type: ignore[arg-type]
    config.set_all_high_dim(False)
    config.front_camera = CameraConfig(image_size=(16, 12), point_cloud=False)
    return config


def test_joint_poses_are_those_of_the_simulated_links() -> None:
    """One world pose per arm joint, of the frame that the joint moves; the last ticks count."""
    with Environment(JointPositionActionMode(), obs_config=small_config(), seed=0) as env:
        task = env.get_task("reach_target")
        task.reset(seed=0)
        for _ in range(3):
            seen, _, _ = task.step(np.append(np.full(7, 0.05), 0.04))
        poses = seen.misc["joint_poses"]
        assert isinstance(poses, list) and len(poses) == 7
        for i, pose in enumerate(poses):
            link = task.world.robot.link_pose(f"panda_link{i + 1}")
            np.testing.assert_allclose(pose[:3], link[:3], atol=1e-6)
            assert abs(pose[3:] @ link[3:]) == pytest.approx(1.0, abs=1e-6)
        task.runtime.cameras.config.joint_poses = False
        assert "joint_poses" not in task.get_observation().misc


def test_descriptions_are_the_instructions_of_the_episode() -> None:
    """On every observation, also after going back to a state of another variation; each list is the caller's own."""
    with Environment(JointPositionActionMode(), obs_config=small_config(), seed=0) as env:
        task = env.get_task("reach_target")
        first, seen = task.reset(seed=0, variation=0)
        state = task.get_state()
        assert seen.misc["descriptions"] == first
        seen.misc["descriptions"].clear()
        second, seen = task.reset(seed=0, variation=3)
        assert seen.misc["descriptions"] == second != first
        assert task.step(np.append(np.zeros(7), 0.04))[0].misc["descriptions"] == second
        assert task.set_state(state).misc["descriptions"] == first


def test_names_of_masks_come_with_masks_only() -> None:
    """Every id in a mask has its name; without masks there are none."""
    config = small_config()
    with Environment(JointPositionActionMode(), obs_config=config, seed=0) as env:
        task = env.get_task("reach_target")
        _, seen = task.reset(seed=0)
        names = seen.misc["mask_names"]
        assert names == task.world.masks
        assert set(np.unique(seen.front_mask).tolist()) - {0} <= names.keys()
        names.clear()
        assert task.get_observation().misc["mask_names"] == task.world.masks
        config.front_camera.mask = False
        assert "mask_names" not in task.get_observation().misc


def test_episode_files_hold_descriptions_once_and_bring_them_back(tmp_path: Path) -> None:
    """A frame reads as it was written, with the instructions or without, lazily or whole."""
    frames = [Observation(joint_positions=np.zeros(7), misc={"descriptions": ["reach it", "go there"]}) for _ in range(3)]
    same = Demo(frames, instructions=("reach it", "go there"), task_name="reach_target")
    other = Demo(frames, instructions=("something else",), task_name="reach_target")
    bare = Demo([Observation(joint_positions=np.zeros(7))] * 3, instructions=("reach it", "go there"), task_name="reach_target")
    for name, demo in {"same": same, "other": other, "bare": bare}.items():
        with Episode(write_demo(demo, tmp_path / name)) as stored:
            assert [o.misc for o in stored.demo()] == [o.misc for o in stored] == [o.misc for o in demo]
            assert stored.misc("descriptions") == [o.misc.get("descriptions") for o in demo]
            assert encode_demo(stored.demo()) == (tmp_path / name).read_bytes()
    assert (tmp_path / "same").stat().st_size < (tmp_path / "bare").stat().st_size + 200


@pytest.mark.simulation
def test_recorded_demonstrations_keep_what_misc_said(tmp_path: Path) -> None:
    """Names of masks and descriptions are stored, joint poses are left to the model."""
    images = ImageConfig(cameras=("front",), products=("mask",), image_size=(16, 12))
    with images.environment() as env:
        task = env.get_task("reach_target")
        demo = task.get_demos(1, live_demos=True, seed=0)[0]
        with Episode(DatasetWriter(tmp_path).add(demo)) as stored:
            frame = stored[5]
        assert frame.misc["descriptions"] == list(demo.instructions)
        assert frame.misc["mask_names"] == task.world.masks
        assert "joint_poses" not in frame.misc
