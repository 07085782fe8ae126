"""SAC of Stable-Baselines3 with what RLPD (Ball et al. 2023) adds for demonstrations, and imitation of them."""

from __future__ import annotations

import torch
from stable_baselines3 import SAC
from stable_baselines3.common.buffers import ReplayBuffer
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor, create_mlp
from stable_baselines3.common.type_aliases import ReplayBufferSamples
from stable_baselines3.common.utils import polyak_update
from stable_baselines3.common.vec_env import VecNormalize
from stable_baselines3.sac.policies import ContinuousCritic, SACPolicy
from torch import Tensor, nn

from rlbench_pin.evaluation.baselines.reinforcement.demonstrations import Experience

ACTOR_EVERY = 2
"""Steps of the critics for one of the actor."""
IMITATION = 0.3
"""What the squared distance to a demonstrated action costs, where success pays 1."""


class HalfDemonstrations(ReplayBuffer):
    """A replay buffer; the second half of each batch comes from demonstrations, once they are there."""

    demonstrations: ReplayBuffer | None = None

    def hold(self, experience: Experience) -> None:
        """Keep demonstrations, apart from what is experienced, which in time replaces itself."""
        kept = ReplayBuffer(len(experience), self.observation_space, self.action_space, self.device)
        rows = zip(experience.seen, experience.then, experience.actions, experience.rewards, experience.ends)
        for seen, then, action, reward, end in rows:
            kept.add(seen[None], then[None], action[None], reward[None], end[None], [{}])
        self.demonstrations = kept

    def sample(self, batch_size: int, env: VecNormalize | None = None) -> ReplayBufferSamples:
        """Draw a batch."""
        if self.demonstrations is None:
            return super().sample(batch_size, env)
        half = batch_size // 2
        parts = (super().sample(batch_size - half, env), self.demonstrations.sample(half, env))
        names = ("observations", "actions", "next_observations", "dones", "rewards")
        return ReplayBufferSamples(*(torch.cat([getattr(part, name) for part in parts]) for name in names))


class NormedCritics(SACPolicy):
    """The networks of SAC, with a layer norm behind every hidden layer of the critics: values stay near those of the data."""

    def make_critic(self, features_extractor: BaseFeaturesExtractor | None = None) -> ContinuousCritic:
        """Return the critics."""
        critic = super().make_critic(features_extractor)
        for index, plain in enumerate(critic.q_networks):
            first = next(plain.children())
            assert isinstance(first, nn.Linear)
            layers = create_mlp(first.in_features, 1, list(self.net_arch), post_linear_modules=[nn.LayerNorm])  # type: ignore[arg-type]
            critic.q_networks[index] = nn.Sequential(*layers)
            critic.add_module(f"qf{index}", critic.q_networks[index])
        return critic.to(self.device)


class ImitatingSac(SAC):
    """SAC that keeps its actor near demonstrations, where it has some; entropy is not part of what its critics learn.

    Attributes:
        is_actor_still: Whether the critics alone learn.
    """

    is_actor_still = False
    replay_buffer: HalfDemonstrations

    def train(self, gradient_steps: int, batch_size: int = 256) -> None:
        """Do some steps of the critics, and half as many of the actor."""
        self.policy.set_training_mode(True)
        losses: dict[str, float] = {}
        for step in range(gradient_steps):
            batch = self.replay_buffer.sample(batch_size, env=self._vec_normalize_env)
            losses["critic_loss"] = self._fit_critics(batch)
            if step % ACTOR_EVERY == 0 and not self.is_actor_still:
                losses |= self._improve_actor(batch)
            polyak_update(self.critic.parameters(), self.critic_target.parameters(), self.tau)
        for name, loss in losses.items():
            self.logger.record(f"train/{name}", loss)

    def _fit_critics(self, batch: ReplayBufferSamples) -> float:
        with torch.no_grad():
            actions, _ = self.actor.action_log_prob(batch.next_observations)
            later = _least(self.critic_target(batch.next_observations, actions))
            target = batch.rewards + (1.0 - batch.dones) * self.gamma * later
        found = self.critic(batch.observations, batch.actions)
        loss = torch.stack([nn.functional.mse_loss(each, target) for each in found]).sum()
        _step(self.critic.optimizer, loss)
        return float(loss.detach())

    def _improve_actor(self, batch: ReplayBufferSamples) -> dict[str, float]:
        actions, likelihood = self.actor.action_log_prob(batch.observations)
        assert isinstance(self.log_ent_coef, Tensor) and isinstance(self.target_entropy, float)
        surplus = (likelihood + self.target_entropy).detach().mean()
        _step(self.ent_coef_optimizer, -(self.log_ent_coef * surplus).sum())
        weight = self.log_ent_coef.detach().exp()
        loss = (weight * likelihood[:, None] - _least(self.critic(batch.observations, actions))).mean()
        if self.replay_buffer.demonstrations is not None:
            shown = slice(len(batch.actions) - len(batch.actions) // 2, None)
            mean, _, _ = self.actor.get_action_dist_params(batch.observations[shown])
            loss = loss + IMITATION * (torch.tanh(mean) - batch.actions[shown]).square().sum(dim=1).mean()
        _step(self.actor.optimizer, loss)
        return {"actor_loss": float(loss.detach()), "ent_coef": float(weight)}


def _least(values: tuple[Tensor, ...]) -> Tensor:
    return torch.cat(values, dim=1).min(dim=1, keepdim=True).values


def _step(optimizer: torch.optim.Optimizer | None, loss: Tensor) -> None:
    assert optimizer is not None
    optimizer.zero_grad()
    loss.backward()  # type: ignore[no-untyped-call]
    optimizer.step()
