"""A first policy that imitates demonstrations, for PPO and for SAC."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import torch
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.vec_env import VecNormalize

from rlbench_pin.evaluation.baselines.reinforcement.demonstrations import Experience

SPREAD = -2.2
"""Logarithm of how far an imitating policy explores at first, in units of the largest action."""
BATCH, RATE = 256, 1e-3

Means = Callable[[torch.Tensor], torch.Tensor]


def imitate(model: PPO | SAC, env: VecNormalize, experience: Experience, steps: int) -> None:
    """Fit the most likely action of an untrained model to that of demonstrations, by least squares, in some batches."""
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
    policy = model.policy
    assert isinstance(policy, ActorCriticPolicy)
    with torch.no_grad():
        policy.log_std.fill_(SPREAD)
    weights = [*policy.mlp_extractor.policy_net.parameters(), *policy.action_net.parameters()]
    return lambda seen: policy.get_distribution(seen).mode(), weights


def _of_sac(model: SAC) -> tuple[Means, list[torch.nn.Parameter]]:
    actor = model.actor
    assert isinstance(actor.log_std, torch.nn.Linear)
    with torch.no_grad():
        actor.log_std.weight.zero_()
        actor.log_std.bias.fill_(SPREAD)
    weights = [*actor.latent_pi.parameters(), *actor.mu.parameters()]
    return lambda seen: torch.tanh(actor.get_action_dist_params(seen)[0]), weights
