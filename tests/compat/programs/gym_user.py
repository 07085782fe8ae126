"""Someone who comes from gymnasium: makes environments by their ids, random actions, images, several at once."""

import gymnasium as gym
import numpy as np
from gymnasium.utils.env_checker import check_env

import rlbench  # noqa: F401  registers the ids

STATE_KEYS = {
    "joint_velocities",
    "joint_positions",
    "joint_forces",
    "gripper_open",
    "gripper_pose",
    "gripper_joint_positions",
    "gripper_touch_forces",
    "task_low_dim_state",
}


def main():
    ids = [name for name in gym.registry if name.startswith("rlbench/")]
    print(len(ids), "ids")
    assert "rlbench/reach_target-vision-v0" in ids

    env = gym.make("rlbench/reach_target-state-v0")
    assert set(env.observation_space.spaces) == STATE_KEYS, env.observation_space
    observation, info = env.reset(seed=6)
    assert env.observation_space.contains(observation)
    assert isinstance(info["text_descriptions"][0], str)
    start = observation["joint_positions"]
    env.action_space.seed(0)
    total = 0.0
    for step in range(30):
        observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
        total += reward
        assert env.observation_space.contains(observation) and not truncated
        if terminated:
            observation, info = env.reset()
    assert np.abs(observation["joint_positions"] - start).max() > 0.01
    again, _ = env.reset(seed=6)
    assert np.allclose(again["task_low_dim_state"], env.reset(seed=6)[0]["task_low_dim_state"])
    check_env(env.unwrapped, skip_render_check=True)
    env.close()

    env = gym.make("rlbench/push_button-vision-v0", render_mode="rgb_array")
    observation, _ = env.reset()
    assert {"front_rgb", "wrist_rgb", "left_shoulder_rgb", "right_shoulder_rgb"} <= set(observation)
    assert observation["front_rgb"].dtype == np.uint8 and env.observation_space.contains(observation)
    frame = env.render()
    assert frame.shape == (360, 640, 3) and frame.dtype == np.uint8 and frame.std() > 10
    env.close()
    print("thirty steps, return", total, "; image", frame.shape)


if __name__ == "__main__":
    main()
