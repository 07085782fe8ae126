"""PPO and SAC with demonstrations."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import torch
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.buffers import ReplayBuffer
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor, create_mlp
from stable_baselines3.common.type_aliases import ReplayBufferSamples
from stable_baselines3.common.utils import polyak_update
from stable_baselines3.common.vec_env import VecNormalize
from stable_baselines3.sac.policies import ContinuousCritic, SACPolicy
from torch import Tensor, nn

from rlbench_pin.baselines.reinforcement.environment import (
    MIN_CHECKPOINT_STEPS,
    TICKS,
    LearningEnv,
    ReinforcementConfig,
    as_unit,
    features,
)
from rlbench_pin.errors import DemoError
from rlbench_pin.observation import Demo

IMITATED_SPREAD = -2.2
"""Initial logarithm of the standard deviation of actions after imitation; the largest action is 1."""
BATCH, RATE = 256, 1e-3
"""Batch size and initial learning rate of imitation."""

Means = Callable[[torch.Tensor], torch.Tensor]


def imitate(model: PPO | SAC, env: VecNormalize, experience: Experience, steps: int) -> None:
    """Fit the most likely actions of an untrained model to demonstrated actions by least squares.

    Args:
        model: Untrained model.
        env: Environments of the model, with the statistics for normalization.
        experience: Transitions of the demonstrations.
        steps: Number of batches.
    """
    means, weights = _of_ppo(model) if isinstance(model, PPO) else _of_sac(model)
    seen = torch.as_tensor(env.normalize_obs(experience.seen), device=model.device)
    actions = torch.as_tensor(experience.actions, device=model.device)
    optimizer, rng = torch.optim.Adam(weights, lr=RATE), np.random.default_rng(model.seed)
    schedule = torch.optim.lr_scheduler.LinearLR(optimizer, 1.0, 0.05, total_iters=steps)
    for _ in range(steps):
        rows = torch.as_tensor(rng.integers(len(experience), size=BATCH), device=model.device)
        loss = torch.nn.functional.mse_loss(means(seen[rows]), actions[rows])
        optimizer.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        optimizer.step()
        schedule.step()


def _of_ppo(model: PPO) -> tuple[Means, list[torch.nn.Parameter]]:
    """Set the initial exploration, and return a function from observations to mean actions, and the weights to train."""
    policy = model.policy
    assert isinstance(policy, ActorCriticPolicy)
    with torch.no_grad():
        policy.log_std.fill_(IMITATED_SPREAD)
    weights = [*policy.mlp_extractor.policy_net.parameters(), *policy.action_net.parameters()]
    return lambda seen: policy.get_distribution(seen).mode(), weights


def _of_sac(model: SAC) -> tuple[Means, list[torch.nn.Parameter]]:
    """Set the initial exploration, and return a function from observations to mean actions, and the weights to train."""
    actor = model.actor
    assert isinstance(actor.log_std, torch.nn.Linear)
    with torch.no_grad():
        actor.log_std.weight.zero_()
        actor.log_std.bias.fill_(IMITATED_SPREAD)
    weights = [*actor.latent_pi.parameters(), *actor.mu.parameters()]
    return lambda seen: torch.tanh(actor.get_action_dist_params(seen)[0]), weights


ACTOR_EVERY = 2
"""Number of steps of the critics per step of the actor."""
IMITATION = 0.3
"""Weight of the squared distance to a demonstrated action in the loss of the actor; the reward of success is 1."""


class HalfDemonstrations(ReplayBuffer):
    """Replay buffer that takes the second half of each batch from demonstrations, if there are any."""

    demonstrations: ReplayBuffer | None = None

    def hold(self, experience: Experience) -> None:
        """Store demonstrations separately; new experience does not overwrite them."""
        kept = ReplayBuffer(len(experience), self.observation_space, self.action_space, self.device)
        rows = zip(experience.seen, experience.then, experience.actions, experience.rewards, experience.ends)
        for seen, then, action, reward, end in rows:
            kept.add(seen[None], then[None], action[None], reward[None], end[None], [{}])
        self.demonstrations = kept

    def sample(self, batch_size: int, env: VecNormalize | None = None) -> ReplayBufferSamples:
        """Return a random batch; with demonstrations its second half comes from them."""
        if self.demonstrations is None:
            return super().sample(batch_size, env)
        half = batch_size // 2
        parts = (super().sample(batch_size - half, env), self.demonstrations.sample(half, env))
        names = ("observations", "actions", "next_observations", "dones", "rewards")
        return ReplayBufferSamples(*(torch.cat([getattr(part, name) for part in parts]) for name in names))


class NormedCritics(SACPolicy):
    """Networks of SAC with a layer norm after each hidden layer of the critics, which limits extrapolation of the values."""

    def make_critic(self, features_extractor: BaseFeaturesExtractor | None = None) -> ContinuousCritic:
        """Return critics with layer norm."""
        critic = super().make_critic(features_extractor)
        for index, plain in enumerate(critic.q_networks):
            first = next(plain.children())
            assert isinstance(first, nn.Linear)
            layers = create_mlp(first.in_features, 1, list(self.net_arch), post_linear_modules=[nn.LayerNorm])  # type: ignore[arg-type]
            critic.q_networks[index] = nn.Sequential(*layers)
            critic.add_module(f"qf{index}", critic.q_networks[index])
        return critic.to(self.device)


class ImitatingSac(SAC):
    """SAC with an imitation loss for the actor on demonstrations, and without entropy in the target of the critics.

    Attributes:
        is_actor_frozen: Whether only the critics learn.
    """

    is_actor_frozen = False
    replay_buffer: HalfDemonstrations

    def train(self, gradient_steps: int, batch_size: int = 256) -> None:
        """Train the critics for `gradient_steps` steps and the actor for half as many."""
        self.policy.set_training_mode(True)
        losses: dict[str, float] = {}
        for step in range(gradient_steps):
            batch = self.replay_buffer.sample(batch_size, env=self._vec_normalize_env)
            losses["critic_loss"] = self._fit_critics(batch)
            if step % ACTOR_EVERY == 0 and not self.is_actor_frozen:
                losses |= self._improve_actor(batch)
            polyak_update(self.critic.parameters(), self.critic_target.parameters(), self.tau)
        for name, loss in losses.items():
            self.logger.record(f"train/{name}", loss)

    def _fit_critics(self, batch: ReplayBufferSamples) -> float:
        """Do one step of the critics, and return their loss."""
        with torch.no_grad():
            actions, _ = self.actor.action_log_prob(batch.next_observations)
            later = _smallest(self.critic_target(batch.next_observations, actions))
            target = batch.rewards + (1.0 - batch.dones) * self.gamma * later
        found = self.critic(batch.observations, batch.actions)
        loss = torch.stack([nn.functional.mse_loss(each, target) for each in found]).sum()
        _step(self.critic.optimizer, loss)
        return float(loss.detach())

    def _improve_actor(self, batch: ReplayBufferSamples) -> dict[str, float]:
        """Do one step of the entropy coefficient and of the actor, and return their values for the log."""
        actions, likelihood = self.actor.action_log_prob(batch.observations)
        assert isinstance(self.log_ent_coef, Tensor) and isinstance(self.target_entropy, float)
        surplus = (likelihood + self.target_entropy).detach().mean()
        _step(self.ent_coef_optimizer, -(self.log_ent_coef * surplus).sum())
        weight = self.log_ent_coef.detach().exp()
        loss = (weight * likelihood[:, None] - _smallest(self.critic(batch.observations, actions))).mean()
        if self.replay_buffer.demonstrations is not None:
            shown = slice(len(batch.actions) - len(batch.actions) // 2, None)
            mean, _, _ = self.actor.get_action_dist_params(batch.observations[shown])
            loss = loss + IMITATION * (torch.tanh(mean) - batch.actions[shown]).square().sum(dim=1).mean()
        _step(self.actor.optimizer, loss)
        return {"actor_loss": float(loss.detach()), "ent_coef": float(weight)}


def _smallest(values: tuple[Tensor, ...]) -> Tensor:
    """Return the smaller value of the critics for each row, shape (n, 1)."""
    return torch.cat(values, dim=1).min(dim=1, keepdim=True).values


def _step(optimizer: torch.optim.Optimizer | None, loss: Tensor) -> None:
    assert optimizer is not None
    optimizer.zero_grad()
    loss.backward()  # type: ignore[no-untyped-call]
    optimizer.step()


FIRST_SEED = 2**32
"""Seed of the first demonstration; the seeds of training episodes are below 2^31."""
MAX_TRIES = 3
"""Maximum number of planned demonstrations per requested one."""
NOISE = 0.15
"""Standard deviation of the noise on the actions of the arm; it adds states beside the demonstrated path."""
TIMES = 2
"""Number of replays of each demonstration."""


@dataclass(frozen=True)
class Experience:
    """Transitions: row i of each array belongs to transition i."""

    seen: np.ndarray
    """Features before the action, float32 (n, m)."""
    then: np.ndarray
    """Features after the action, float32 (n, m)."""
    actions: np.ndarray
    """Actions, between -1 and 1, float32 (n, k)."""
    rewards: np.ndarray
    """Rewards, float32 (n,)."""
    ends: np.ndarray
    """1 where the episode ended, else 0, float32 (n,)."""

    @classmethod
    def joined(cls, parts: Sequence[Experience]) -> Experience:
        """Return the concatenation of several records."""
        names = ("seen", "then", "actions", "rewards", "ends")
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))

    def __len__(self) -> int:
        """Return the number of transitions."""
        return len(self.seen)


def gather(env: LearningEnv, count: int, on_demo: Callable[[int, int], None] = lambda done, wanted: None) -> Experience:
    """Plan demonstrations, replay them with the actions of the learner, and return the transitions of successful replays.

    The variations alternate.

    Args:
        env: Environment of the task.
        count: Number of demonstrations.
        on_demo: Function that is called after each demonstration with the number found and the number requested.

    Raises:
        DemoError: Fewer than `count` demonstrations succeed.
    """
    found: list[Experience] = []
    for index in range(MAX_TRIES * count):
        outcome = env.task.try_demo(seed=FIRST_SEED + index, variation=index % env.task.variation_count())
        if outcome.demo is None:
            continue
        rng = np.random.default_rng(FIRST_SEED + index)
        played = [p for p in (follow(env, outcome.demo, rng) for _ in range(TIMES)) if p is not None]
        if played:
            found.append(Experience.joined(played))
            on_demo(len(found), count)
        if len(found) == count:
            return Experience.joined(found)
    raise DemoError(
        f"{len(found)} of {MAX_TRIES * count} demonstrations succeed with the actions of the learner; {count} are wanted."
        " Longer episodes may help: --episode-steps."
    )


def follow(env: LearningEnv, demo: Demo, rng: np.random.Generator) -> Experience | None:
    """Replay joints and gripper of a demonstration with noise; return the transitions, or None without success.

    The noise has mean zero, and later actions correct it, so the mean action is the demonstrated one.
    """
    seen, rows = env.reset_to(demo), []
    for index in range(TICKS, 2 * len(demo), TICKS):
        goal = demo[min(index, len(demo) - 1)]
        joints, wanted = np.asarray(seen.joint_positions), np.asarray(goal.joint_positions)
        clean = as_unit(joints, wanted, (goal.gripper_open or 0.0) > 0.5)
        noise = np.append(rng.normal(scale=NOISE, size=len(clean) - 1), 0.0)
        action = np.clip(clean + noise, -1.0, 1.0).astype(np.float32)
        before = features(seen)
        after, reward, over, cut, info = env.step(action)
        rows.append((before, after, action, np.float32(reward), np.float32(over)))
        seen = info["observation"]
        if over or cut:
            return Experience(*(np.array(column, np.float32) for column in zip(*rows))) if info["is_success"] else None
    return None


NETWORK = (128, 128)
"""Neurons per hidden layer of actors and critics."""
DISCOUNT = 0.97
"""Discount factor per decision."""
PPO_SETTINGS: Mapping[str, Any] = {"batch_size": 128, "n_epochs": 10, "learning_rate": 5e-4, "clip_range": 0.2}
SAC_SETTINGS: Mapping[str, Any] = {
    "batch_size": 256,
    "buffer_size": 100_000,
    "train_freq": MIN_CHECKPOINT_STEPS,
    "gradient_steps": 16,
}
SAC_FROM_SCRATCH: Mapping[str, Any] = {"learning_rate": 1e-3, "learning_starts": 1000, "ent_coef": "auto_0.1"}
"""Settings of SAC without demonstrations: random actions first, and the default target entropy, minus the action size."""
SAC_AFTER_IMITATION: Mapping[str, Any] = {
    "learning_rate": 3e-4,
    "learning_starts": 0,
    "ent_coef": "auto_0.01",
    "target_entropy": -16.0,
}
"""Settings of SAC after imitation: a smaller learning rate, and half the exploration (0.03 of the largest action)."""
SPREAD = -0.5
"""Initial logarithm of the standard deviation of PPO without demonstrations; the largest action is 1."""
CLONED_RATE = 1e-4
"""Learning rate of PPO after imitation; larger steps destroy the imitated policy."""
WARM_UP: Mapping[str, int] = {"ppo": 2, "sac": 1}
"""Number of first segments after imitation in which only the values learn and the policy is frozen."""

Model: TypeAlias = "PPO | ImitatingSac"


def make_model(config: ReinforcementConfig, env: VecNormalize) -> Model:
    """Return an untrained model; `config.seed` determines its initial weights."""
    networks: dict[str, Any] = {"net_arch": list(NETWORK), "optimizer_kwargs": {"fused": True}}
    common: dict[str, Any] = {"gamma": DISCOUNT, "seed": config.seed % 2**31, "device": config.device, "verbose": 0}
    if config.algorithm == "sac":
        common |= SAC_AFTER_IMITATION if config.demonstrations else SAC_FROM_SCRATCH
        return ImitatingSac(
            NormedCritics, env, replay_buffer_class=HalfDemonstrations, policy_kwargs=networks, **SAC_SETTINGS, **common
        )
    settings = {**PPO_SETTINGS, **({"learning_rate": CLONED_RATE} if config.demonstrations else {})}
    settings["batch_size"] = min(settings["batch_size"], config.segment)
    networks["log_std_init"] = SPREAD
    return PPO("MlpPolicy", env, n_steps=config.segment // config.workers, policy_kwargs=networks, **settings, **common)


def start_from_demonstrations(model: Model, env: VecNormalize, experience: Experience, steps: int) -> None:
    """Initialize an untrained model from demonstrations.

    Its policy imitates them, SAC stores them in its buffer, and `env` gets their statistics for normalization.
    """
    env.obs_rms.update(experience.seen)  # type: ignore[union-attr]
    imitate(model, env, experience, steps)
    if isinstance(model, ImitatingSac):
        model.replay_buffer.hold(experience)


def freeze_policy(model: Model, frozen: bool) -> None:
    """Freeze the policy, so that only the values learn; or unfreeze it."""
    if isinstance(model, ImitatingSac):
        model.is_actor_frozen = frozen
        return
    policy = model.policy
    assert isinstance(policy, ActorCriticPolicy)
    for weight in (*policy.mlp_extractor.policy_net.parameters(), *policy.action_net.parameters(), policy.log_std):
        weight.requires_grad_(not frozen)
