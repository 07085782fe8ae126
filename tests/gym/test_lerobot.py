"""Environments as LeRobot evaluates policies on them: its keys, its attributes, its way of making and stepping them."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env, data_equivalence

from rlbench_pin.errors import TaskEnvironmentError, UnknownName
from rlbench_pin.gym.lerobot import TASKS_VARIABLE, LeRobotEnv, make_env
from rlbench_pin.gym.vector import LazyAsyncVectorEnv
from rlbench_pin.tasks import task_names

HUB_FILE = Path(__file__).resolve().parents[2] / "examples" / "lerobot" / "env.py"
SMALL = {"cameras": ("front", "wrist"), "image_size": (32, 24)}


pytestmark = pytest.mark.filterwarnings("ignore:.*symmetric and normalized space:UserWarning")


@pytest.fixture(scope="module")
def reach() -> Iterator[LeRobotEnv]:
    """reach_target with two small cameras."""
    env = LeRobotEnv("reach_target", max_episode_steps=5, **SMALL)
    yield env
    env.close()


def hub_make_env() -> Callable[..., Any]:
    """Load `make_env` from the file as the hub does: by its path."""
    spec = importlib.util.spec_from_file_location("hub_env", HUB_FILE)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.make_env  # type: ignore[no-any-return]


def rollout(env: Any, policy: Callable[[dict[str, Any]], np.ndarray], seeds: list[int]) -> dict[str, Any]:
    """Play one batch of episodes in the way of LeRobot's evaluation, with numpy in place of tensors."""
    observation, _ = env.reset(seed=seeds, options={"lerobot_new_rollout": True})
    done = np.zeros(env.num_envs, dtype=bool)
    successes, rewards, sentences = [], [], []
    for _ in range(env.call("_max_episode_steps")[0]):
        for picture in observation["pixels"].values():
            _, h, w, c = picture.shape
            assert picture.dtype == np.uint8 and c < h and c < w
        sentences.append(list(env.call("task_description")))
        observation, reward, terminated, truncated, info = env.step(policy(observation))
        successes.append(info.get("final_info", info)["is_success"] & ~done)
        rewards.append(reward * ~done)
        done |= terminated | truncated
        if done.all():
            break
    return {
        "success": np.any(successes, axis=0),
        "reward": np.sum(rewards, axis=0),
        "sentences": sentences,
        "steps": len(rewards),
    }


@pytest.mark.simulation
def test_checker_has_nothing_to_say(reach: LeRobotEnv) -> None:
    """Gymnasium's checker passes."""
    check_env(reach, skip_render_check=True)


def test_observations_and_attributes_are_lerobots(reach: LeRobotEnv) -> None:
    """Images by camera, joints and gripper, the task, what is asked for, the length of an episode."""
    observation, info = reach.reset(seed=2)
    assert {name: p.shape for name, p in observation["pixels"].items()} == {"front": (24, 32, 3), "wrist": (24, 32, 3)}
    assert observation["agent_pos"].shape == (8,) and observation["agent_pos"].dtype == np.float32
    assert observation["agent_pos"][-1] == 1.0
    assert (reach.task, reach._max_episode_steps) == ("reach_target", 5)
    assert reach.task_description == info["text_descriptions"][0]
    assert info["is_success"] is False and info["task"] == "reach_target"


@pytest.mark.simulation
def test_variations_are_drawn_from_the_seed(reach: LeRobotEnv) -> None:
    """Seeds ask for different colours, the same seed for the same, and the description follows."""
    asked = []
    for seed in (0, 1, 2, 3, 0):
        reach.reset(seed=seed)
        asked.append(reach.task_description)
    assert len(set(asked)) > 1 and asked[0] == asked[-1]


def test_an_episode_is_cut_off(reach: LeRobotEnv) -> None:
    """After the last step the episode is truncated, not terminated."""
    observation, _ = reach.reset(seed=0)
    ends = [reach.step(observation["agent_pos"])[2:4] for _ in range(5)]
    assert ends == [(False, False)] * 4 + [(False, True)]


@pytest.mark.simulation
def test_recorded_actions_succeed() -> None:
    """Actions as they stand in a dataset, joint positions and gripper, reach the goal, and the evaluation sees it."""
    vector = make_env(tasks=["reach_target"], variation=0, max_episode_steps=60, **SMALL)["rlbench_pin"]
    env = vector[task_names().index("reach_target")]
    demo = env.envs[0].unwrapped.world.task_environment.get_demos(1, live_demos=True, seed=4)[0]
    actions = iter([*(frame.misc["joint_position_action"] for frame in demo[1:])])
    result = rollout(env, lambda _: next(actions)[None].astype(np.float32), [4])
    env.close()
    assert result["success"].tolist() == [True] and result["reward"].tolist() == [1.0]


@pytest.mark.simulation
def test_nothing_is_built_before_it_is_used_and_closing_frees() -> None:
    """All tasks can be asked for at once; a world is built when it is first used, freed at the end, and may be built again."""
    suite = make_env(n_envs=2, **SMALL)["rlbench_pin"]
    assert list(suite) == list(range(len(task_names())))
    assert all(env.unwrapped._env is None for vector in suite.values() for env in vector.envs)
    vector = suite[task_names().index("open_drawer")]
    assert vector.num_envs == 2 and vector.single_action_space.shape == (8,)
    observation, _ = vector.reset(seed=[0, 1])
    assert observation in vector.observation_space
    assert list(vector.call("task")) == ["open_drawer"] * 2
    vector.close()
    assert all(env.unwrapped._env is None for env in vector.envs)
    again, _ = vector.envs[0].reset(seed=0)
    vector.envs[0].close()
    np.testing.assert_array_equal(again["agent_pos"], observation["agent_pos"][0])


def test_tasks_come_from_settings_or_the_environment_variable(monkeypatch: pytest.MonkeyPatch) -> None:
    """`cfg.task` and `cfg.episode_length` are used, and without them the environment variable."""
    cfg = SimpleNamespace(task="push_button, open_drawer", episode_length=7)
    suite = make_env(cfg=cfg, **SMALL)["rlbench_pin"]
    assert [task_names()[i] for i in suite] == ["push_button", "open_drawer"]
    drawer = suite[task_names().index("open_drawer")]
    assert drawer.call("_max_episode_steps") == (7,)
    drawer.close()
    monkeypatch.setenv(TASKS_VARIABLE, "reach_target")
    assert [task_names()[i] for i in hub_make_env()()["rlbench_pin"]] == ["reach_target"]


@pytest.mark.slow
def test_hub_file_makes_four_processes_that_agree_with_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the hub loads plays four episodes, and in processes of their own the same ones."""
    monkeypatch.setenv(TASKS_VARIABLE, "reach_target")

    def still(observation: dict[str, Any]) -> np.ndarray:
        return observation["agent_pos"]

    results = []
    for asynchronous in (False, True):
        env = hub_make_env()(n_envs=4, use_async_envs=asynchronous, cfg=SimpleNamespace(episode_length=6))
        vector = next(iter(env["rlbench_pin"].values()))
        assert isinstance(vector, LazyAsyncVectorEnv if asynchronous else gymnasium.vector.SyncVectorEnv)
        assert not asynchronous or not vector.is_running
        results.append(rollout(vector, still, [1, 2, 3, 4]))
        pictures = vector.call("render")
        assert len(pictures) == 4 and pictures[0].shape == (360, 640, 3)
        vector.close()
        vector.close()
        assert not asynchronous or not vector.is_running
    assert data_equivalence(results[0], results[1])
    assert results[0]["steps"] == 6 and len(set(results[0]["sentences"][0])) > 1


@pytest.mark.parametrize(
    ("arguments", "error", "says"),
    [
        ({"n_envs": 0}, TaskEnvironmentError, "n_envs .* Got 0"),
        ({"tasks": ["reach_targt"]}, UnknownName, "Did you mean 'reach_target'"),
        ({"tasks": ["reach_target"], "cameras": ("frnt",)}, UnknownName, "Did you mean 'front'"),
        ({"tasks": ["reach_target"], "max_episode_steps": 0}, TaskEnvironmentError, "max_episode_steps .* Got 0"),
        ({"tasks": ["reach_target"], "image_sise": (8, 8)}, TypeError, "image_sise"),
    ],
)
def test_bad_arguments_are_errors_at_once(arguments: dict[str, Any], error: type[Exception], says: str) -> None:
    """Mistakes show when the environments are asked for, not when they are first used."""
    with pytest.raises(error, match=says):
        make_env(**arguments)


@pytest.mark.slow
def test_lerobots_own_evaluation_plays_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """LeRobot loads the hub file, accepts what it returns, and its rollout with a recorded demonstration as policy succeeds."""
    pytest.importorskip("lerobot")
    torch = pytest.importorskip("torch")
    utils = importlib.import_module("lerobot.envs.utils")
    evaluation = importlib.import_module("lerobot.scripts.lerobot_eval")
    monkeypatch.setenv(TASKS_VARIABLE, "reach_target")
    made = utils._load_module_from_path(str(HUB_FILE)).make_env(n_envs=1, use_async_envs=False)
    env = utils._normalize_hub_result(made)["rlbench_pin"][task_names().index("reach_target")]
    task = env.envs[0].unwrapped.world.task_environment
    demo = task.get_demos(1, live_demos=True, seed=4)[0]
    task.set_variation(-1)

    class Recorded(torch.nn.Module):  # type: ignore[misc, name-defined]
        """Says what was recorded, and keeps what it was shown."""

        def reset(self) -> None:
            self.actions, self.seen = iter(demo[1:]), []

        def select_action(self, observation: dict[str, Any]) -> Any:
            self.seen.append(observation)
            return torch.tensor(next(self.actions).misc["joint_position_action"], dtype=torch.float32)[None]

    def same(x: Any) -> Any:
        return x

    policy = Recorded()
    result = evaluation.rollout(env, policy, same, same, same, same, seeds=[4])
    env.close()
    assert result["success"].any() and result["done"][0, -1] and result["reward"].sum() == 1.0
    assert policy.seen[0]["observation.images.front"].shape == (1, 3, 128, 128)
    assert policy.seen[0]["observation.state"].shape == (1, 8)
    assert "ball" in policy.seen[0]["task"][0] or "sphere" in policy.seen[0]["task"][0]
