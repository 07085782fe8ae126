"""The known gymnasium ids: spaces, seeds, several environments in one process."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np
import pytest

import rlbench  # noqa: F401  registers the ids
from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import JointVelocity
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.gym import RLBenchEnv, convert_dtype_to_float32_if_float
from rlbench.tasks import ReachTarget

pytestmark = pytest.mark.simulation


@pytest.fixture(scope="module")
def env() -> Iterator[gymnasium.Env[Any, Any]]:
    """The reach task with images."""
    environment = gymnasium.make("rlbench/reach_target-vision-v0", render_mode="rgb_array")
    yield environment
    environment.close()


def test_ids() -> None:
    """All tasks of the public set have two ids, flagged nondeterministic."""
    known = [spec for name, spec in gymnasium.registry.items() if name.startswith("rlbench/")]
    assert len(known) >= 2 * 106
    assert all(spec.nondeterministic for spec in known)


def test_spaces(env: gymnasium.Env[Any, Any]) -> None:
    """Observations lie in their space: float32 boxes and four images; actions are eight numbers."""
    observation, info = env.reset(seed=0)
    assert env.observation_space.contains(observation)
    images = sorted(name for name in observation if name.endswith("_rgb"))
    assert images == ["front_rgb", "left_shoulder_rgb", "right_shoulder_rgb", "wrist_rgb"]
    assert {observation[name].dtype for name in observation if name not in images} == {np.dtype(np.float32)}
    assert env.action_space.shape == (8,)
    assert info["text_descriptions"]
    for _ in range(2):
        observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
    assert env.observation_space.contains(observation)
    assert (reward, terminated, truncated, info["success"]) == (0.0, False, False, False)
    image: Any = env.render()
    assert image.shape == (360, 640, 3)
    assert env.metadata["render_fps"] == 4


def test_two_environments_do_not_meet(env: gymnasium.Env[Any, Any]) -> None:
    """The same seed gives the same episode in both, and steps of one leave the other alone."""
    with_class = RLBenchEnv(ReachTarget, action_mode=MoveArmThenGripper(JointVelocity(), Discrete()))
    first, _ = env.reset(seed=7)
    second, _ = with_class.reset(seed=7)
    assert np.array_equal(first["task_low_dim_state"], second["task_low_dim_state"])
    with_class.step(np.array([1.0] * 7 + [1.0], dtype=np.float32))
    still, *_ = env.step(np.zeros(8, dtype=np.float32))
    assert np.allclose(still["joint_positions"], first["joint_positions"], atol=5e-3)
    with_class.close()
    with_class.close()
    env.reset(seed=8)


def test_reset_to_demo(env: gymnasium.Env[Any, Any]) -> None:
    """The option starts as the demonstration did."""
    unwrapped: Any = env.unwrapped
    demo = unwrapped.rlbench_task_env.get_demos(1, live_demos=True)[0]
    env.reset(seed=1)
    observation, _ = env.reset(options={"reset_to_demo": demo})
    assert np.allclose(observation["task_low_dim_state"], demo[0].task_low_dim_state, atol=1e-6)


def test_vector_environments() -> None:
    """Environments side by side in one process."""
    vector = gymnasium.make_vec("rlbench/reach_target-state-v0", num_envs=2, vectorization_mode="sync")
    observation, _ = vector.reset(seed=[1, 2])
    assert observation["joint_positions"].shape == (2, 7)
    assert not np.array_equal(*observation["task_low_dim_state"])
    vector.step(vector.action_space.sample())
    vector.close()


def test_choices() -> None:
    """Modes that there are not are a ValueError; types of numbers become float32 where they are floating."""
    with pytest.raises(ValueError, match="pixels"):
        RLBenchEnv(ReachTarget, "pixels")
    with pytest.raises(ValueError, match="ansi"):
        RLBenchEnv(ReachTarget, render_mode="ansi")
    assert convert_dtype_to_float32_if_float(np.dtype(np.float64)) == np.float32
    assert convert_dtype_to_float32_if_float(np.dtype(np.uint8)) == np.uint8
