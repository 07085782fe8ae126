"""PPO and SAC of Stable-Baselines3 with our settings, and what demonstrations do in each."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

from stable_baselines3 import PPO
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.vec_env import VecNormalize

from rlbench_pin.evaluation.baselines.reinforcement.config import LEAST_LEG, ReinforcementConfig
from rlbench_pin.evaluation.baselines.reinforcement.demonstrations import Experience
from rlbench_pin.evaluation.baselines.reinforcement.imitation import imitate
from rlbench_pin.evaluation.baselines.reinforcement.off_policy import HalfDemonstrations, ImitatingSac, NormedCritics

NETWORK = (128, 128)
"""Neurons of the hidden layers, of actors and critics."""
DISCOUNT = 0.97
"""What a reward one decision later is worth."""
PPO_SETTINGS: Mapping[str, Any] = {"batch_size": 128, "n_epochs": 10, "learning_rate": 5e-4, "clip_range": 0.2}
SAC_SETTINGS: Mapping[str, Any] = {
    "batch_size": 256,
    "buffer_size": 100_000,
    "train_freq": LEAST_LEG,
    "gradient_steps": 16,
}
SAC_FROM_NOTHING: Mapping[str, Any] = {"learning_rate": 1e-3, "learning_starts": 1000, "ent_coef": "auto_0.1"}
"""Decisions at random first; the goal of entropy is the usual one, minus the numbers of an action."""
SAC_AFTER_IMITATION: Mapping[str, Any] = {
    "learning_rate": 3e-4,
    "learning_starts": 0,
    "ent_coef": "auto_0.01",
    "target_entropy": -16.0,
}
"""Smaller steps, and half as far beside the path: 0.03 of the largest action for each number."""
SPREAD = -0.5
"""Logarithm of how far PPO explores at first without demonstrations, in units of the largest action."""
CLONED_RATE = 1e-4
"""Learning rate of PPO after imitation: large steps forget what was imitated."""
WARM_UP: Mapping[str, int] = {"ppo": 2, "sac": 1}
"""Legs in which the values of an imitating policy are learned, and it stays as it is."""

Model: TypeAlias = PPO | ImitatingSac


def make_model(config: ReinforcementConfig, env: VecNormalize) -> Model:
    """Return an untrained model; its first weights follow from the seed."""
    networks: dict[str, Any] = {"net_arch": list(NETWORK), "optimizer_kwargs": {"fused": True}}
    common: dict[str, Any] = {"gamma": DISCOUNT, "seed": config.seed % 2**31, "device": config.device, "verbose": 0}
    if config.algorithm == "sac":
        common |= SAC_AFTER_IMITATION if config.demonstrations else SAC_FROM_NOTHING
        return ImitatingSac(
            NormedCritics, env, replay_buffer_class=HalfDemonstrations, policy_kwargs=networks, **SAC_SETTINGS, **common
        )
    settings = {**PPO_SETTINGS, **({"learning_rate": CLONED_RATE} if config.demonstrations else {})}
    settings["batch_size"] = min(settings["batch_size"], config.leg)
    networks["log_std_init"] = SPREAD
    return PPO("MlpPolicy", env, n_steps=config.leg // config.workers, policy_kwargs=networks, **settings, **common)


def teach(model: Model, env: VecNormalize, experience: Experience, steps: int) -> None:
    """Give demonstrations to an untrained model: it begins with a policy that imitates them, and SAC keeps them in its buffer.

    The statistics of what is seen are those of the demonstrations.
    """
    env.obs_rms.update(experience.seen)  # type: ignore[union-attr]
    imitate(model, env, experience, steps)
    if isinstance(model, ImitatingSac):
        model.replay_buffer.hold(experience)


def hold_still(model: Model, still: bool) -> None:
    """Let a model change its values alone, or all of its weights."""
    if isinstance(model, ImitatingSac):
        model.is_actor_still = still
        return
    policy = model.policy
    assert isinstance(policy, ActorCriticPolicy)
    for weight in (*policy.mlp_extractor.policy_net.parameters(), *policy.action_net.parameters(), policy.log_std):
        weight.requires_grad_(not still)
