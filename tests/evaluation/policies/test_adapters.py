"""Policies of other forms act as they do at home."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rlbench_pin.environment import (
    Environment,
    JointPositionActionMode,
    ObservationConfig,
    TaskEnvironment,
    key_frame_actions,
)
from rlbench_pin.evaluation.policies import (
    FunctionPolicy,
    KeyFrame,
    KeyFramePolicy,
    PolicyContext,
    PolicyFault,
    PolicySettings,
    lerobot_directory,
    open_policy,
)
from rlbench_pin.evaluation.policies.lerobot_directory import read_features
from rlbench_pin.observation import Demo, Observation

CONTEXT = PolicyContext("panda", 7, (-1.0,) * 7 + (0.0,), (1.0,) * 8, 0.05, 100, seed=1)


def test_noop_and_random() -> None:
    """One stays as the episode began; the other draws within the bounds, the same for the same seed."""
    noop, random = open_policy("noop"), open_policy("random")
    first, later = (Observation(joint_positions=np.full(7, x), gripper_open=1.0) for x in (0.1, 0.2))
    noop.reset("anything", CONTEXT)
    assert noop.act(first).tolist() == noop.act(later).tolist() == [0.1] * 7 + [1.0]
    noop.reset("anything", CONTEXT)
    assert noop.act(later).tolist() == [0.2] * 7 + [1.0]
    draws = []
    for _ in range(2):
        random.reset("anything", CONTEXT)
        draws.append([random.act(first) for _ in range(50)])
    np.testing.assert_array_equal(draws[0], draws[1])
    low, high = np.array(CONTEXT.action_low), np.array(CONTEXT.action_high)
    assert ((draws[0] >= low) & (draws[0] <= high)).all() and np.std(draws[0], axis=0).min() > 0.2


def test_functions_see_what_gymnasium_delivers() -> None:
    """Numbers are float32 of one dimension, images are images."""
    seen: list[Any] = []

    def act(observation: dict[str, np.ndarray]) -> list[float]:
        seen.append({name: (value.dtype.name, value.shape) for name, value in observation.items()})
        return [0.5] * 8

    client = open_policy(FunctionPolicy(act, JointPositionActionMode(), ObservationConfig(), begin=seen.append))
    client.reset("go", CONTEXT)
    picture = np.zeros((4, 4, 3), np.uint8)
    assert client.act(Observation(gripper_open=1.0, joint_positions=np.zeros(7), front_rgb=picture)).tolist() == [0.5] * 8
    assert seen == [
        "go", {"front_rgb": ("uint8", (4, 4, 3)), "joint_positions": ("float32", (7,)), "gripper_open": ("float32", (1,))},
    ]  # fmt: skip


class FromDemo(KeyFramePolicy):
    """Predicts the key frames of a demonstration."""

    def __init__(self, demo: Demo) -> None:
        config = ObservationConfig()
        config.set_all(False)
        super().__init__(config)
        self.frames = iter(key_frame_actions(demo))

    def predict(self, observation: Observation, instruction: str) -> KeyFrame:
        """Return the next one, its quaternion of another length."""
        frame = next(self.frames)
        return KeyFrame(frame[:7] * np.array([1.0] * 3 + [2.0] * 4), bool(frame[7]), bool(frame[8]))


def test_key_frames_are_actions() -> None:
    """Pose, gripper and collisions in the order of `key_frame_actions`; what is no pose is refused."""
    poses = [np.array([0.3, 0.0, z, 0.0, 1.0, 0.0, 0.0]) for z in (1.0, 1.1)]
    frames = [
        Observation(gripper_pose=pose, gripper_open=1.0, joint_velocities=np.zeros(7), ignore_collisions=True) for pose in poses
    ]
    policy = FromDemo(Demo(frames))
    expected = key_frame_actions(Demo(frames))
    client = open_policy(policy)
    assert client.settings.action_mode["arm_settings"]["retry_without_checks"] is True and client.settings.max_steps == 25
    client.reset("go", CONTEXT)
    np.testing.assert_allclose(client.act(frames[0]), expected[0])
    policy.frames = iter([np.zeros(9)])
    with pytest.raises(PolicyFault, match="norm zero"):
        client.act(frames[0])


# Stable-Baselines3 ------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def task() -> Iterator[TaskEnvironment]:
    """A task whose observations gymnasium delivers."""
    pytest.importorskip("stable_baselines3")
    from rlbench_pin.environment.observations.observe import boxed_settings

    with Environment(JointPositionActionMode(), obs_config=boxed_settings(("front",), (48, 36))) as environment:
        yield environment.get_task("reach_target")


def context_of(task: TaskEnvironment) -> PolicyContext:
    """Return what a policy is told."""
    low, high = task.action_bounds()
    return PolicyContext("panda", 7, tuple(low), tuple(high), 0.05, 10, seed=1)


def trained(kind: str, wrap: Any, file: Path, vision: bool = False, **settings: Any) -> tuple[Any, Any]:
    """Return an untrained model, saved to a file, and what it says about the first observation of an episode."""
    import stable_baselines3

    from rlbench_pin.gym import GymnasiumEnv

    images: dict[str, Any] = {"observation_mode": "vision", "image_size": (48, 36), "cameras": ("front",)} if vision else {}
    env = wrap(GymnasiumEnv("reach_target", **images))
    words = "MultiInputPolicy" if hasattr(env.observation_space, "spaces") else "MlpPolicy"
    model = getattr(stable_baselines3, kind)(words, env, seed=0, device="cpu", policy_kwargs={"net_arch": [8]}, **settings)
    model.save(file)
    observation, _ = env.reset(seed=5)
    action = model.predict(observation, deterministic=True)[0]
    env.close()
    return model, action


@pytest.mark.simulation
@pytest.mark.parametrize(
    ("kind", "vision", "flat", "unit"),
    [("PPO", False, False, False), ("PPO", True, False, False), ("SAC", False, True, True), ("A2C", False, False, True)],
)
def test_models_of_stable_baselines3(
    tmp_path: Path, task: TaskEnvironment, kind: str, vision: bool, flat: bool, unit: bool
) -> None:
    """What a model in a file answers is what it answers on our gymnasium environments, to the last bit of a float32."""
    from gymnasium.wrappers import FlattenObservation, RescaleAction

    def wrap(env: Any) -> Any:
        env = FlattenObservation(env) if flat else env
        return RescaleAction(env, np.float32(-1.0), np.float32(1.0)) if unit else env

    model, expected = trained(kind, wrap, tmp_path / "model.zip", vision, **({"buffer_size": 10} if kind == "SAC" else {}))
    _, seen = task.reset(seed=5, variation=0)
    from rlbench_pin.evaluation.policies.sb3 import load

    client = open_policy(load(str(tmp_path / "model.zip")))
    assert client.settings.make_obs_config().front_camera.is_used == vision
    client.reset("go", context_of(task))
    low, high = task.action_bounds()
    wanted = (low + high) / 2 + expected.astype(float) * (high - low) / 2 if unit else expected
    np.testing.assert_allclose(client.act(seen), wanted, rtol=0, atol=1e-6)
    assert type(model).__name__ == kind


@pytest.mark.simulation
def test_a_model_in_a_process_of_its_own(tmp_path: Path, task: TaskEnvironment) -> None:
    """By name; a file of another action mode, or of none of our observations, is refused."""
    _, expected = trained("PPO", lambda env: env, tmp_path / "model.zip")
    client = open_policy(f"sb3:{tmp_path}/model")
    _, seen = task.reset(seed=5, variation=0)
    client.reset("go", context_of(task))
    np.testing.assert_allclose(client.act(seen), expected, rtol=0, atol=1e-6)
    client.close()
    from rlbench_pin.evaluation.policies.sb3 import load

    other = open_policy(load(str(tmp_path / "model.zip"), arm="EndEffectorVelocity"))
    with pytest.raises(PolicyFault, match="7 numbers|8 numbers"):
        other.reset("go", CONTEXT.__class__("panda", 7, (0.0,) * 7, (1.0,) * 7, 0.05, 10, seed=1))
    with pytest.raises(PolicyFault, match="other bounds"):
        other.reset("go", CONTEXT)


# LeRobot ----------------------------------------------------------------------------------------------------------------------

FEATURES: dict[str, Any] = {
    "input_features": {
        "observation.state": {"type": "STATE", "shape": [8]},
        "observation.images.front": {"type": "VISUAL", "shape": [3, 48, 64]},
    },
    "output_features": {"action": {"type": "ACTION", "shape": [8]}},
}


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({}, ""),
        ({"output_features": {}}, "has no output feature `action`"),
        ({"input_features": {"observation.environment_state": {"shape": [3]}}}, "environment_state"),
        ({"input_features": {"observation.state": {"shape": [6]}}}, r"states \[6\] and actions \[8\]"),
    ],
)
def test_features_of_a_directory(tmp_path: Path, change: dict[str, Any], says: str) -> None:
    """Cameras and their sizes, and how many joints; what no export of ours has is refused."""
    (tmp_path / "config.json").write_text(json.dumps({**FEATURES, **change}))
    if says:
        with pytest.raises(ValueError, match=says):
            read_features(tmp_path)
    else:
        assert read_features(tmp_path) == ({"front": (64, 48)}, 8)


DOUBLE = """
from types import SimpleNamespace
import torch


class Policy:
    def from_pretrained(folder, config):
        assert config.type == "double"
        return Policy()

    def to(self, device):
        return self

    def eval(self):
        return self

    def reset(self):
        self.calls = 0

    def select_action(self, frame):
        self.calls += 1
        image = frame["observation.images.front"]
        assert image.shape == (1, 3, 48, 64) and image.dtype == torch.float32 and frame["task"] == "go"
        return frame["observation.state"] * self.calls + image.mean()


class PreTrainedConfig:
    def from_pretrained(folder):
        return SimpleNamespace(type="double")


def get_policy_class(name):
    return Policy


def make_pre_post_processors(policy_cfg, pretrained_path, preprocessor_overrides):
    return (lambda frame: frame), (lambda action: 2.0 * action)
"""


@pytest.mark.simulation
def test_a_directory_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With a double of the library: state, images in 0..1 and the instruction go in, and the gripper comes back within 0..1."""
    pytest.importorskip("torch")
    for package in ("lerobot", "lerobot/policies", "lerobot/configs"):
        (tmp_path / package).mkdir()
        (tmp_path / package / "__init__.py").touch()
    for module in ("policies/factory", "configs/policies"):
        (tmp_path / "lerobot" / f"{module}.py").write_text(DOUBLE)
    (tmp_path / "pretrained_model").mkdir()
    (tmp_path / "pretrained_model" / "config.json").write_text(json.dumps(FEATURES))
    monkeypatch.syspath_prepend(str(tmp_path))
    client = open_policy(f"lerobot:{tmp_path}/pretrained_model?device=cpu&max_steps=9")
    assert client.settings.max_steps == 9
    client.reset("go", CONTEXT)
    picture = np.full((48, 64, 3), 51, np.uint8)
    seen = Observation(joint_positions=np.arange(7.0), gripper_open=1.0, front_rgb=picture)
    np.testing.assert_allclose(client.act(seen), [*(2.0 * (np.arange(7.0) + 0.2)), 1.0], atol=1e-6)
    np.testing.assert_allclose(client.act(seen), [*(2.0 * (2.0 * np.arange(7.0) + 0.2)), 1.0], atol=1e-6)
    with pytest.raises(PolicyFault, match="but the arm has 6"):
        client.reset("go", PolicyContext("other", 6, (0.0,) * 7, (1.0,) * 7, 0.05, 100, seed=1))
    client.close()


LEROBOT = os.environ.get("RLBENCH_PIN_LEROBOT_PYTHON", "")
SCRIPT = Path(__file__).with_name("lerobot_directory_check.py")


@pytest.mark.skipif(not LEROBOT, reason="RLBENCH_PIN_LEROBOT_PYTHON names no Python that has LeRobot")
def test_a_directory_of_lerobot(tmp_path: Path) -> None:
    """What we get from a directory is what LeRobot's own `predict_action` gets, in an environment without rlbench_pin."""
    command = [LEROBOT, str(SCRIPT), str(Path(lerobot_directory.__file__).parent), str(tmp_path / "act")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout.splitlines()[-1])
    np.testing.assert_array_equal(said["ours"], said["theirs"])
    settings = PolicySettings.of(said["action_mode"], said["obs_config"])
    assert settings.make_obs_config().front_camera.image_size == (64, 48)
