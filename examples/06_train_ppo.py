"""Learn to reach: PPO of Stable-Baselines3 on `rlbench_pin/reach_target-state-v0` (`pip install -e '.[rl]'` in a clone).

The policy observes the tip and the ball, and returns a tip velocity 20 times per second. Its reward is the shaped reward of the
task, the negative distance to the ball. An episode ends when the tip touches the ball, or after 50 steps. Success is the sparse
reward of the benchmark.

What to look for: the mean reward per episode rises, and the fraction of touched balls rises from almost 0 to almost 1.
`train_ppo.png` has the learning curve. The training takes a few minutes on one core.
"""

from __future__ import annotations

import time

import gymnasium
import matplotlib.pyplot as plt
import numpy as np
from stable_baselines3 import PPO
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.monitor import Monitor

from rlbench_pin.environment import Discrete, EndEffectorVelocity, MoveArmThenGripper

STEPS = 20_000
EPISODE = 50
SPEED = 0.5  # of the tip, at most, along each axis [m/s]
TESTS = range(1_000_000, 1_000_030)  # seeds that training does not meet
IMAGE_FILE = "train_ppo.png"


class TipVelocity(gymnasium.ActionWrapper):
    """Three numbers in -1..1 for the linear tip velocity; the gripper keeps its orientation and stays open."""

    def __init__(self, env: gymnasium.Env) -> None:
        super().__init__(env)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (3,), np.float32)

    def action(self, action: np.ndarray) -> np.ndarray:
        return np.concatenate([SPEED * np.clip(action, -1.0, 1.0), np.zeros(3), [1.0]])


class TipAndBall(gymnasium.ObservationWrapper):
    """Position of the ball relative to the tip, and position of the tip [m]."""

    def __init__(self, env: gymnasium.Env) -> None:
        super().__init__(env)
        self.observation_space = gymnasium.spaces.Box(-3.0, 3.0, (6,), np.float32)

    def observation(self, observation: dict[str, np.ndarray]) -> np.ndarray:
        tip, ball = observation["gripper_pose"][:3], observation["task_low_dim_state"]
        return np.concatenate([ball - tip, tip])


class Progress(BaseCallback):
    """Prints a line after each round of training."""

    def __init__(self, episodes: Monitor, steps: int) -> None:
        super().__init__()
        self.episodes, self.steps = episodes, steps

    def _on_step(self) -> bool:
        return True

    def _on_rollout_end(self) -> None:
        rewards = self.episodes.get_episode_rewards()[-20:]
        print(f"{self.num_timesteps} of {self.steps} steps, mean reward of the last episodes {np.mean(rewards):.2f}", flush=True)


def make(shaped: bool = True) -> gymnasium.Env:
    """Return the environment of the policy."""
    env = gymnasium.make(
        "rlbench_pin/reach_target-state-v0",
        max_episode_steps=EPISODE,
        action_mode=MoveArmThenGripper(EndEffectorVelocity(), Discrete()),
        shaped_rewards=shaped,
    )
    return TipVelocity(TipAndBall(env))


def evaluate(policy: BaseAlgorithm, env: gymnasium.Env) -> tuple[float, float]:
    """Return the mean reward per episode and the success rate over the test seeds."""
    rewards, successes = [], []
    for seed in TESTS:
        observation, info = env.reset(seed=seed)
        total, over = 0.0, False
        while not over:
            action, _ = policy.predict(observation, deterministic=True)
            observation, reward, terminated, truncated, info = env.step(action)
            total, over = total + float(reward), terminated or truncated
        rewards.append(total)
        successes.append(info["success"])
    return float(np.mean(rewards)), float(np.mean(successes))


def draw(episodes: Monitor, title: str) -> None:
    """Draw the reward of each training episode, and the mean of the last 20."""
    rewards, steps = np.array(episodes.get_episode_rewards()), np.cumsum(episodes.get_episode_lengths())
    means = [rewards[max(0, i - 19) : i + 1].mean() for i in range(len(rewards))]
    figure, axes = plt.subplots(figsize=(6.4, 3.2), layout="constrained")
    axes.plot(steps, rewards, ".", markersize=3, color="0.7", label="one episode")
    axes.plot(steps, means, color="tab:blue", label="mean of the last 20")
    axes.set(title=title, xlabel="steps of training", ylabel="reward per episode")
    axes.legend(frameon=False, loc="lower right")
    figure.savefig(IMAGE_FILE, dpi=110)


def main(shaped: bool = True, steps: int = STEPS) -> None:
    """Train, evaluate before and after, and draw."""
    env = make(shaped)
    episodes = Monitor(env)
    policy = PPO("MlpPolicy", episodes, n_steps=1024, batch_size=64, gamma=0.95, learning_rate=1e-3, seed=0, device="cpu")
    print(f"playing {len(TESTS)} test episodes before the training", flush=True)
    before = evaluate(policy, env)
    began = time.perf_counter()
    policy.learn(steps, callback=Progress(episodes, steps))
    rate = policy.num_timesteps / (time.perf_counter() - began)
    after = evaluate(policy, env)
    draw(episodes, f"PPO on reach_target, {'shaped' if shaped else 'sparse'} reward")
    env.close()
    print(f"{policy.num_timesteps} steps of training, {rate:.0f} a second")
    for moment, (reward, success) in (("before", before), ("after", after)):
        print(f"{moment}: mean reward {reward:.2f} per episode, {100 * success:.0f} % of {len(TESTS)} balls touched")
    print(f"the mean reward has {'risen' if after[0] > before[0] else 'not risen'}; the curve is in {IMAGE_FILE}")


if __name__ == "__main__":
    main()
