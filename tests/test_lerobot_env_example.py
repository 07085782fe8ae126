"""The package in `examples/lerobot_env_rlbench_pin` gives LeRobot our tasks, under the names of our exports."""

from __future__ import annotations

import importlib
import importlib.metadata
import importlib.util
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import gymnasium
import numpy as np
import pytest

from rlbench_pin.errors import UnknownName
from rlbench_pin.gym import LeRobotEnv

PACKAGE = "lerobot_env_rlbench_pin"
FOLDER = Path(__file__).resolve().parents[1] / "examples" / PACKAGE
SMALL: dict[str, Any] = {"cameras": ["front", "wrist"], "observation_height": 24, "observation_width": 32, "variation": 0}


class _Settings:
    """What the package uses of LeRobot's `EnvConfig`, where LeRobot is not installed."""

    @classmethod
    def register_subclass(cls, name: str) -> Any:
        return lambda subclass: subclass


@dataclass
class _StandIn(_Settings):
    """Fields of LeRobot's `EnvConfig`."""

    task: str | None = None
    fps: int = 30
    features: dict[str, Any] = field(default_factory=dict)
    features_map: dict[str, str] = field(default_factory=dict)
    max_parallel_tasks: int = 1
    disable_env_checker: bool = True


CONTENTS: dict[str, dict[str, Any]] = {
    "lerobot": {},
    "lerobot.configs": {},
    "lerobot.configs.types": {
        "FeatureType": SimpleNamespace(ACTION="ACTION", STATE="STATE", VISUAL="VISUAL"),
        "PolicyFeature": lambda type, shape: SimpleNamespace(type=type, shape=shape),
    },
    "lerobot.envs": {},
    "lerobot.envs.configs": {"EnvConfig": _StandIn},
    "lerobot.utils": {},
    "lerobot.utils.constants": {"ACTION": "action", "OBS_IMAGES": "observation.images", "OBS_STATE": "observation.state"},
}


@pytest.fixture(scope="module")
def package() -> Iterator[ModuleType]:
    """The package, imported once, with LeRobot, or with what stands in for it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(FOLDER))
        if importlib.util.find_spec("lerobot") is None:
            for name, content in CONTENTS.items():
                module = ModuleType(name)
                vars(module).update(content)
                patch.setitem(sys.modules, name, module)
        yield importlib.import_module(PACKAGE)
    del sys.modules[PACKAGE], gymnasium.registry["rlbench_pin/LeRobot-v0"]


def made(config: Any) -> Any:
    """Return an environment as LeRobot's factory makes it."""
    return gymnasium.make(config.gym_id, disable_env_checker=config.disable_env_checker, **config.gym_kwargs)


def test_features_are_those_of_the_environment_and_of_exports(package: ModuleType) -> None:
    """Shapes as observed, keys as `rlbench-pin dataset export lerobot` writes them."""
    config = package.RlbenchPinEnv(task="reach_target", episode_length=5, **SMALL)
    assert config.package_name == PACKAGE
    assert config.features_map == {
        "action": "action",
        "agent_pos": "observation.state",
        "pixels/front": "observation.images.front",
        "pixels/wrist": "observation.images.wrist",
    }
    env = made(config)
    space = env.observation_space
    shapes = {"action": env.action_space.shape, "agent_pos": space["agent_pos"].shape}
    shapes |= {f"pixels/{name}": box.shape for name, box in space["pixels"].spaces.items()}
    assert {name: feature.shape for name, feature in config.features.items()} == shapes
    env.close()


def test_the_environment_is_ours_without_wrappers(package: ModuleType) -> None:
    """LeRobot reads the instruction and the length of an episode from what `gymnasium.make` returns."""
    env = made(package.RlbenchPinEnv(task="reach_target", episode_length=3, **SMALL))
    assert isinstance(env, LeRobotEnv)
    observation, info = env.reset(seed=2)
    assert env.task_description == info["text_descriptions"][0] and env.task == "reach_target"
    ends = [env.step(observation["agent_pos"])[2:4] for _ in range(env.get_wrapper_attr("_max_episode_steps"))]
    assert ends == [(False, False), (False, False), (False, True)]
    env.close()


def test_what_does_not_exist_is_named(package: ModuleType) -> None:
    """A task and a camera; the nearest name is proposed."""
    with pytest.raises(UnknownName, match="Did you mean 'reach_target'"):
        made(package.RlbenchPinEnv(task="reach_targt", **SMALL))
    with pytest.raises(UnknownName, match="Did you mean 'front'"):
        made(package.RlbenchPinEnv(task="reach_target", **{**SMALL, "cameras": ["frnt"]}))


@pytest.mark.simulation
def test_the_installed_name_has_the_prefix(tmp_path: Path) -> None:
    """LeRobot 0.6 imports what begins so, by the name in the metadata: it has to be that of the module."""
    pytest.importorskip("hatchling")
    pip = [sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--no-build-isolation", "--disable-pip-version-check"]
    subprocess.run([*pip, "--target", str(tmp_path), str(FOLDER)], check=True, timeout=120)
    names = [found.metadata["Name"] for found in importlib.metadata.distributions(path=[str(tmp_path)])]
    assert names == [PACKAGE] and (tmp_path / PACKAGE / "__init__.py").is_file()


@pytest.mark.slow
def test_lerobots_factory_and_rollout_play_it(package: ModuleType) -> None:
    """LeRobot makes the environment from its settings, and a recorded demonstration as policy succeeds in its rollout."""
    torch = pytest.importorskip("torch")
    utils = pytest.importorskip("lerobot.envs.utils")
    config = importlib.import_module("lerobot.envs.configs").EnvConfig.get_choice_class("rlbench_pin")(**SMALL)
    assert isinstance(config, package.RlbenchPinEnv)
    assert {name: tuple(feature.shape) for name, feature in utils.env_to_policy_features(config).items()} == {
        "action": (8,),
        "observation.state": (8,),
        "observation.images.front": (3, 24, 32),
        "observation.images.wrist": (3, 24, 32),
    }
    vector = importlib.import_module("lerobot.envs.factory").make_env(config, n_envs=1)["rlbench_pin"][0]
    demo = vector.envs[0].world.task_environment.get_demos(1, live_demos=True, seed=4)[0]

    class Recorded(torch.nn.Module):  # type: ignore[misc, name-defined]
        """Says what was recorded, and keeps what it was shown."""

        def reset(self) -> None:
            self.actions = iter(demo[1:])
            self.seen: list[dict[str, Any]] = []

        def select_action(self, observation: dict[str, Any]) -> Any:
            self.seen.append(observation)
            return torch.tensor(next(self.actions).misc["joint_position_action"], dtype=torch.float32)[None]

    def same(x: Any) -> Any:
        return x

    policy = Recorded()
    rollout = importlib.import_module("lerobot.scripts.lerobot_eval").rollout
    result = rollout(vector, policy, same, same, same, same, seeds=[4])
    vector.close()
    assert result["success"].any() and float(np.asarray(result["reward"]).sum()) == 1.0
    assert policy.seen[0]["observation.state"].shape == (1, 8)
    assert policy.seen[0]["task"] == [demo.instructions[0]]
