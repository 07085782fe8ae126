"""Stored demonstrations under the known names: the generator, both layouts, pickles, images of numbers."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from rlbench import CameraConfig, Environment, ObservationConfig, dataset_generator
from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import JointPosition
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.backend import const, utils
from rlbench.backend.observation import Observation
from rlbench.demo import Demo
from rlbench.tasks import PushButton, ReachTarget
from rlbench.utils import InvalidTaskName, get_stored_demos, name_to_task_class

pytestmark = pytest.mark.simulation
ARGUMENTS = ["--tasks=push_button,reach_target", "--image_size=32,32", "--seed", "3", "--renderer", "opengl"]


@pytest.fixture(scope="module")
def upstream(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two variations of two tasks with an episode each, a folder for each variation."""
    root = tmp_path_factory.mktemp("upstream")
    settings = ["--save_path", str(root), "--episodes_per_task", "1", "--variations", "2"]
    assert dataset_generator.main([*settings, *ARGUMENTS]) == 0
    return root


@pytest.fixture(scope="module")
def together(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three episodes of two tasks, all variations in one folder."""
    root = tmp_path_factory.mktemp("together") / "new"
    settings = ["--save_path", str(root), "--episodes_per_task=3", "--all_variations=True"]
    assert dataset_generator.main([*settings, *ARGUMENTS]) == 0
    return root


def small(cameras: tuple[str, ...] = ("front",)) -> ObservationConfig:
    """All low-dimensional data, and small images of some cameras."""
    config = ObservationConfig()
    config.set_all_high_dim(False)
    config.set_all_low_dim(True)
    for name in cameras:
        camera = config.camera(name)
        camera.set_all(True)
        camera.image_size = (32, 32)
    return config


def make(root: Path | str = "", config: ObservationConfig | None = None) -> Environment:
    """Return an environment that has not been launched."""
    mode = MoveArmThenGripper(JointPosition(), Discrete())
    return Environment(mode, str(root), small() if config is None else config, True)


def test_layout_on_disk(upstream: Path, together: Path) -> None:
    """The files lie where programs look for them, and nothing else is there."""
    assert sorted(p.name for p in upstream.iterdir()) == ["push_button", "reach_target"]
    variation = upstream / "reach_target" / (const.VARIATIONS_FOLDER % 0)
    assert sorted(p.name for p in variation.iterdir()) == [const.EPISODES_FOLDER, const.VARIATION_DESCRIPTIONS]
    episode = variation / const.EPISODES_FOLDER / (const.EPISODE_FOLDER % 0)
    folders = sorted(p.name for p in episode.iterdir() if p.is_dir())
    assert len(folders) == 15 and const.WRIST_MASK_FOLDER in folders
    assert (episode / const.FRONT_RGB_FOLDER / (const.IMAGE_FORMAT % 0)).is_file()
    other = together / "push_button" / const.VARIATIONS_ALL_FOLDER / const.EPISODES_FOLDER / (const.EPISODE_FOLDER % 2)
    for name in (const.VARIATION_NUMBER, const.VARIATION_DESCRIPTIONS, const.LOW_DIM_PICKLE):
        with (other / name).open("rb") as file:
            assert pickle.load(file) is not None  # a program that reads the files itself


def test_a_program_reads_the_pickle_itself(upstream: Path) -> None:
    """The classes in the file are our own; what they hold can be used, written and read again."""
    path = upstream / "reach_target/variation1/episodes/episode0/low_dim_obs.pkl"
    with path.open("rb") as file:
        demo = pickle.load(file)
    assert type(demo) is Demo and type(demo[0]) is Observation
    assert demo[0].front_rgb is None and demo.variation_number == 1
    assert demo[-1].get_low_dim_data().shape == demo[0].get_low_dim_data().shape
    again = pickle.loads(pickle.dumps(demo))
    assert np.array_equal(again[5].joint_positions, demo[5].joint_positions)
    assert again.random_seed == demo.random_seed


def test_stored_demos_without_a_simulator(upstream: Path, together: Path) -> None:
    """`Environment.get_demos` reads both layouts; nothing is launched."""
    env = make(upstream)
    demos = env.get_demos("reach_target", 1, variation_number=1, random_selection=False)
    assert env._pyrep is None
    first = demos[0][0]
    assert first.misc["variation_index"] == 1
    assert first.front_rgb is not None and first.front_rgb.shape == (32, 32, 3)
    assert first.front_point_cloud is not None and first.front_point_cloud.shape == (32, 32, 3)
    assert first.front_mask is not None and first.front_mask.dtype == np.int32
    assert first.wrist_rgb is None
    everything = make(together).get_demos("push_button", -1, variation_number=-1, random_selection=False)
    assert len(everything) == 3
    third = make(together).get_demos("push_button", 1, -1, random_selection=False, from_episode_number=2)[0]
    assert third.random_seed == everything[2].random_seed
    sentences = make(together).get_task_descriptions_with_episode("push_button", 2)
    assert sentences == list(everything[2].instructions)
    paths = env.get_demos("reach_target", 1, image_paths=True)[0]
    assert isinstance(paths[3].front_rgb, str) and paths[3].front_rgb.endswith("front_rgb/3.png")
    with pytest.raises(RuntimeError, match="10"):
        env.get_demos("reach_target", 10)
    with pytest.raises(RuntimeError, match="close_jar"):
        env.get_demos("close_jar", 1)


def test_the_global_generator_picks(together: Path) -> None:
    """Random selections repeat with the seed of numpy's global generator."""

    def picked(seed: int) -> list[object]:
        np.random.seed(seed)
        found = get_stored_demos(2, True, str(together), -1, "reach_target", small())
        return [demo.random_seed for demo in found]

    assert picked(1) == picked(1)
    assert len({tuple(picked(seed)) for seed in range(6)}) > 1  # type: ignore[arg-type]


def test_back_to_stored_demos(together: Path) -> None:
    """A task environment with all variations takes its demonstrations up again, one after the other."""
    with make(together) as env:
        task = env.get_task(PushButton)
        task.set_variation(-1)
        for index in range(3):
            demo = task.get_demos(1, live_demos=False, random_selection=False, from_episode_number=index)[0]
            descriptions, start = task.reset_to_demo(demo)
            assert np.allclose(start.task_low_dim_state, demo[0].task_low_dim_state, atol=1e-9)  # type: ignore[arg-type]
            assert descriptions == list(demo.instructions)
            assert task._variation_number == demo.variation_number
            task.set_variation(-1)
        with pytest.raises(RuntimeError, match="dataset root"):
            _without_root(env)


def _without_root(env: Environment) -> None:
    task = env.get_task(ReachTarget)
    task._dataset_root = ""
    task.get_demos(1)


def test_a_live_demo_saved_by_a_program(tmp_path: Path) -> None:
    """Written by `save_demo` or pickled by hand, a live demonstration is read again and reset to."""
    with make(tmp_path) as env:
        task = env.get_task(ReachTarget)
        task.set_variation(4)
        np.random.seed(2)
        demo = task.get_demos(1, live_demos=True)[0]
        episodes = tmp_path / "reach_target" / "variation4" / "episodes"
        dataset_generator.save_demo(demo, str(episodes / "episode0"))
        assert demo[0].front_rgb is not None
        for name in vars(demo[0]):
            if name.endswith(("_rgb", "_depth", "_mask", "_point_cloud")):
                for frame in demo:
                    setattr(frame, name, None)
        by_hand = episodes / "episode1"
        by_hand.mkdir()
        with (by_hand / "low_dim_obs.pkl").open("wb") as file:
            pickle.dump(demo, file)
        np.random.seed(9)
        for index in range(2):
            stored = task.get_demos(1, random_selection=False, from_episode_number=index)[0]
            assert np.array_equal(stored[7].joint_positions, demo[7].joint_positions)  # type: ignore[arg-type]
            assert (stored[0].front_rgb is None) == (index == 1)
            _, start = task.reset_to_demo(stored)
            assert np.array_equal(start.task_low_dim_state, demo[0].task_low_dim_state)  # type: ignore[arg-type]


def test_generator_refusals(upstream: Path, tmp_path: Path) -> None:
    """Unknown tasks are a ValueError with a guess; what is stored is not written over."""
    with pytest.raises(ValueError, match="reach_target"):
        dataset_generator.main(["--save_path", str(tmp_path), "--tasks", "reach_targt"])
    with pytest.raises(RuntimeError, match="already"):
        dataset_generator.main(["--save_path", str(upstream), "--tasks", "reach_target"])
    settings = dataset_generator.parse_args(["--tasks", "a", "b,c", "--image_size", "64", "48", "--all_variations"])
    assert (settings.tasks, settings.image_size, settings.all_variations) == (["a", "b", "c"], [64, 48], True)
    assert (settings.episodes_per_task, settings.variations, settings.processes, settings.seed) == (10, -1, 1, None)


def test_images_of_numbers(upstream: Path) -> None:
    """Depth and masks come back from the helpers as the folder writer stored them, to the last bit."""
    depth = np.random.default_rng(0).random((6, 5), dtype=np.float32)
    picture = utils.float_array_to_rgb_image(depth, scale_factor=const.DEPTH_SCALE)
    back = utils.image_to_float_array(picture, const.DEPTH_SCALE)
    assert np.abs(back.astype(float) - depth).max() < 1e-7
    again = utils.float_array_to_rgb_image(back, const.DEPTH_SCALE)
    assert np.array_equal(utils.image_to_float_array(again, const.DEPTH_SCALE), back)
    folder = upstream / "reach_target/variation0/episodes/episode0"
    stored = make(upstream).get_demos("reach_target", 1, random_selection=False)[0][0]
    assert stored.front_depth is not None
    with Image.open(folder / "front_depth" / "0.png") as image:
        assert np.array_equal(utils.image_to_float_array(image, const.DEPTH_SCALE), stored.front_depth)
        same = utils.float_array_to_rgb_image(stored.front_depth, const.DEPTH_SCALE)
        assert np.array_equal(np.asarray(same), np.asarray(image))
    with Image.open(folder / "front_mask" / "0.png") as image:
        assert np.array_equal(utils.rgb_handles_to_mask(np.array(image)), stored.front_mask)
    gray = utils.float_array_to_grayscale_image(depth, image_dtype=np.uint16)
    assert np.abs(utils.image_to_float_array(gray) - depth).max() < 5.1e-4
    assert utils.ClipFloatValues(np.array([-1.0, 0.5, 2.0, np.nan]), 0.0, 1.0).tolist() == [0.0, 0.5, 1.0, 0.0]


def test_task_classes_by_name() -> None:
    """With or without `.py`; an unknown name proposes a near one."""
    assert name_to_task_class("reach_target") is ReachTarget is utils.task_file_to_task_class("reach_target.py")
    with pytest.raises(InvalidTaskName, match="reach_target"):
        name_to_task_class("reach_targt")


def test_settings_by_position() -> None:
    """Camera and observation settings take their arguments in the known order, sizes as lists too."""
    camera = CameraConfig(True, None, False, None, False, False, [40, 30], "opengl")  # type: ignore[arg-type]
    assert (camera.rgb, camera.depth, camera.image_size, camera.draws_shadows) == (True, False, (40, 30), False)
    config = ObservationConfig(None, None, None, None, camera, False)
    assert config.front_camera is camera and not config.joint_velocities and config.wrist_camera.rgb
    config.set_all_low_dim(True)
    assert config.gripper_matrix and config.task_low_dim_state and not config.record_gripper_closing


def test_the_generator_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was stopped is refused, then resumed: with the seed it had, and each episode once."""
    arguments = ["--save_path", str(tmp_path), "--tasks", "reach_target", "--variations", "1", "--episodes_per_task", "3"]

    def stop(message: str, *numbers: int) -> None:
        if numbers and numbers[0] == 2:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(dataset_generator.logging.getLogger("rlbench.dataset_generator"), "info", stop)
        with pytest.raises(KeyboardInterrupt):
            dataset_generator.main([*arguments, "--image_size", "16", "16"])
    assert not (tmp_path / "reach_target").exists()
    with pytest.raises(RuntimeError, match="resume"):
        dataset_generator.main([*arguments, "--image_size", "16", "16"])
    assert dataset_generator.main([*arguments, "--image_size", "16", "16", "--resume"]) == 0
    demos = make(tmp_path).get_demos("reach_target", -1)
    assert len({demo.random_seed for demo in demos}) == 3
    assert [p.name for p in tmp_path.iterdir()] == ["reach_target"]
