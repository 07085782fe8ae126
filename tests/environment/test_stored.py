"""Stored demonstrations come back as the observation config asks for them, from our files and from RLBench-style folders."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from rlbench_pin import Environment
from rlbench_pin.datasets import read_image
from rlbench_pin.datasets.formats.rlbench import export_rlbench
from rlbench_pin.environment import Discrete, JointPosition, MoveArmThenGripper, ObservationConfig
from rlbench_pin.errors import DatasetError, UnknownName
from rlbench_pin.processes import SerialEngine
from rlbench_pin.recording.config import ImageConfig, RecordConfig
from rlbench_pin.recording.record import record

TASK = "reach_target"
SIZE = (24, 16)


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Real demonstrations: three of each of two variations, two cameras."""
    folder = tmp_path_factory.mktemp("stored")
    images = ImageConfig(cameras=("front", "wrist"), image_size=SIZE, products=("rgb", "depth", "mask", "point_cloud"))
    record(RecordConfig(tasks=(TASK,), episodes=4, variations=2, images=images), folder, engine=SerialEngine())
    return folder


@pytest.fixture(scope="module", params=["ours", "folders"])
def stored(request: pytest.FixtureRequest, root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same in both formats."""
    return root if request.param == "ours" else export_rlbench(root, tmp_path_factory.mktemp("folders") / "data")


def environment(root: Path, config: ObservationConfig | None = None, seed: int = 0) -> Environment:
    """An environment that is never launched."""
    mode = MoveArmThenGripper(JointPosition(), Discrete())
    return Environment(mode, dataset_root=str(root), obs_config=config or fitting(), seed=seed)


def fitting(size: tuple[int, int] = SIZE) -> ObservationConfig:
    """A config for two cameras of a size."""
    config = ObservationConfig()
    config.set_all_high_dim(False)
    for name in ("front", "wrist"):
        config.camera(name).set_all(True)
        config.camera(name).image_size = size
    return config


def variations(root: Path) -> list[int]:
    """Numbers of the stored variations."""
    return sorted(int(p.name.removeprefix("variation")) for p in (root / TASK).glob("variation*"))


@pytest.mark.simulation
def test_no_simulator_is_started(stored: Path) -> None:
    """All demonstrations of a variation, in natural order, from an environment that was never launched."""
    env = environment(stored)
    first, second = variations(stored)
    demos = env.get_demos(TASK, -1, first, random_selection=False)
    assert [d.variation_number for d in demos] == [first, first]
    assert env._runtime is None
    assert len(env.get_demos(TASK, -1, -1)) == 4
    (last,) = env.get_demos(TASK, 1, second, random_selection=False, from_episode_number=1)
    every = env.get_demos(TASK, -1, second, random_selection=False)
    assert last.random_seed == every[1].random_seed


@pytest.mark.simulation
def test_the_first_episode_is_an_index(stored: Path) -> None:
    """With variation -1 through the episodes of all variations, as sentences are counted; too high a number is explained."""
    env = environment(stored)
    seeds = [d.random_seed for d in env.get_demos(TASK, -1, -1, random_selection=False)]
    for first in range(4):
        (demo,) = env.get_demos(TASK, 1, -1, random_selection=False, from_episode_number=first)
        assert demo.random_seed == seeds[first]
        assert demo.instructions == tuple(env.get_task_descriptions_with_episode(TASK, first))
    rest = env.get_demos(TASK, -1, -1, random_selection=False, from_episode_number=1)
    assert [d.random_seed for d in rest] == seeds[1:]
    with pytest.raises(DatasetError, match="3 demos.*has 2 of its 4 from episode 2"):
        env.get_demos(TASK, 3, -1, random_selection=False, from_episode_number=2)
    for number in (4, -1):
        with pytest.raises(DatasetError, match=f"no episode {number} of variation -1.*has 4. Pass .* from 0 to 3"):
            env.get_demos(TASK, 1, -1, random_selection=False, from_episode_number=number)
    with pytest.raises(DatasetError, match="no episode 2 of variation.*has 2. Pass .* from 0 to 1"):
        env.get_demos(TASK, 1, variations(stored)[1], random_selection=False, from_episode_number=2)


@pytest.mark.simulation
def test_random_selection_follows_the_seed(stored: Path) -> None:
    """The same seed of the environment draws the same, another another; never twice the same episode."""
    draws = {seed: tuple(d.random_seed for d in environment(stored, seed=seed).get_demos(TASK, 3, -1)) for seed in range(6)}
    again = tuple(d.random_seed for d in environment(stored, seed=0).get_demos(TASK, 3, -1))
    assert again == draws[0]
    assert len(set(draws.values())) > 1
    assert all(len(set(draw)) == 3 for draw in draws.values())


@pytest.mark.simulation
def test_both_formats_hold_the_same(root: Path, tmp_path: Path) -> None:
    """Folders give what our files give, the point cloud computed from depth and the matrices included."""
    folders = export_rlbench(root, tmp_path / "data")
    for ours, theirs in zip(
        *(environment(r).get_demos(TASK, -1, -1, random_selection=False) for r in (root, folders)), strict=True
    ):
        assert len(ours) == len(theirs)
        for a, b in zip(ours, theirs):
            for name in ("front_rgb", "wrist_mask", "joint_positions", "gripper_pose"):
                assert np.array_equal(getattr(a, name), getattr(b, name))
            assert np.abs(np.subtract(a.front_depth, b.front_depth)).max() < 1.2e-7
            assert b.front_point_cloud is not None
            assert np.abs(np.subtract(a.front_point_cloud, b.front_point_cloud)).max() < 1e-5


def test_what_is_switched_off_is_none(stored: Path) -> None:
    """Fields that the config does not ask for are not read."""
    config = fitting()
    config.joint_forces = config.wrist_camera.rgb = False
    config.front_camera.set_all(False)
    observation = environment(stored, config).get_demos(TASK, 1, -1)[0][0]
    assert (observation.joint_forces, observation.wrist_rgb, observation.front_rgb, observation.front_depth) == (None,) * 4
    assert observation.wrist_mask is not None


def test_pictures_are_scaled_with_their_intrinsics(stored: Path) -> None:
    """Another size: depth and ids stay values that were there, and the point cloud still lies where it lay."""
    (small,) = environment(stored, fitting((12, 8))).get_demos(TASK, 1, -1, random_selection=False)
    (whole,) = environment(stored).get_demos(TASK, 1, -1, random_selection=False)
    a, b = small[3], whole[3]
    assert np.shape(a.front_rgb) == (8, 12, 3)
    assert set(np.unique(np.asarray(a.front_mask))) <= set(np.unique(np.asarray(b.front_mask)))
    assert set(np.unique(np.asarray(a.wrist_depth))) <= set(np.unique(np.asarray(b.wrist_depth)))
    assert np.allclose(a.misc["front_camera_intrinsics"][:2], 0.5 * b.misc["front_camera_intrinsics"][:2])
    low, high = (f(np.asarray(b.front_point_cloud), axis=(0, 1)) for f in (np.min, np.max))
    cloud = np.asarray(a.front_point_cloud)
    assert np.all(cloud > low - 0.2)
    assert np.all(cloud < high + 0.2)


def test_units_are_those_asked_for(stored: Path) -> None:
    """Depth in metres and masks over three channels."""
    config = fitting()
    config.front_camera.depth_in_meters, config.front_camera.masks_as_one_channel = True, False
    (asked,) = environment(stored, config).get_demos(TASK, 1, -1, random_selection=False)
    (plain,) = environment(stored).get_demos(TASK, 1, -1, random_selection=False)
    near, far = (plain[0].misc[f"front_camera_{plane}"] for plane in ("near", "far"))
    assert np.allclose(asked[0].front_depth, near + np.asarray(plain[0].front_depth) * (far - near), atol=1e-5)
    assert np.allclose(np.asarray(asked[0].front_mask) * 255 @ [1, 256, 65536], plain[0].front_mask)
    assert asked[0].misc["front_camera_depth_in_meters"]
    assert "wrist_camera_depth_in_meters" not in asked[0].misc


def test_paths_of_pictures(stored: Path) -> None:
    """With `image_paths` nothing is decoded; the text leads to the image, whatever the format."""
    (demo,) = environment(stored).get_demos(TASK, 1, -1, image_paths=True, random_selection=False)
    (whole,) = environment(stored).get_demos(TASK, 1, -1, random_selection=False)
    text = demo[2].front_rgb
    assert isinstance(text, str)
    image = np.asarray(Image.open(text)) if text.endswith(".png") else read_image(text)
    assert np.array_equal(image, whole[2].front_rgb)
    assert demo[2].joint_positions is not None


def test_sentences_of_an_episode(stored: Path) -> None:
    """They are read without the episode, counted through all variations; a number too high is explained."""
    env = environment(stored)
    demos = env.get_demos(TASK, -1, -1, random_selection=False)
    assert [tuple(env.get_task_descriptions_with_episode(TASK, i)) for i in range(4)] == [d.instructions for d in demos]
    with pytest.raises(DatasetError, match="contains 4 episodes"):
        env.get_task_descriptions_with_episode(TASK, 4)


def test_bad_requests_are_explained(stored: Path, tmp_path: Path) -> None:
    """No root, no such task, no such folder, more than there are, and amounts that are none."""
    env = environment(stored)
    with pytest.raises(RuntimeError, match="5 demos.*has 4"):
        env.get_demos(TASK, 5, -1)
    with pytest.raises(RuntimeError, match="-3 demos"):
        env.get_demos(TASK, -3, -1)
    with pytest.raises(RuntimeError, match="push_button"):
        env.get_demos("push_button", 1)
    with pytest.raises(UnknownName, match="Did you mean 'reach_target'"):
        env.get_demos("reach_targt", 1)
    with pytest.raises(RuntimeError, match="dataset_root"):
        environment(Path("")).__class__(MoveArmThenGripper(JointPosition(), Discrete())).get_demos(TASK, 1)
    with pytest.raises(DatasetError, match="does not exist"):
        environment(tmp_path / "nowhere")


@pytest.mark.simulation
def test_task_environments_serve_them_too(stored: Path) -> None:
    """`TaskEnvironment.get_demos` gives those of its variation, -1 those of all, and `reset_to_demo` takes them."""
    with environment(stored) as env:
        task = env.get_task(TASK)
        first = variations(stored)[0]
        task.set_variation(first)
        (demo,) = task.get_demos(1, random_selection=False)
        assert demo.variation_number == first
        task.set_variation(-1)
        assert len(task.get_demos(-1)) == 4
        instructions, observation = task.reset_to_demo(demo)
        assert tuple(instructions) == demo.instructions
        assert np.array_equal(observation.joint_positions, demo[0].joint_positions)
