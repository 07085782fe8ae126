"""Reinforcement learning: PPO and SAC of Stable-Baselines3 from state, with shaped or sparse reward and demonstrations."""

from __future__ import annotations

from rlbench_pin.errors import MissingExtra

try:
    from rlbench_pin.baselines.reinforcement.environment import LearningEnv, ReinforcementConfig
    from rlbench_pin.baselines.reinforcement.policy import ReinforcementPolicy, policy
    from rlbench_pin.baselines.reinforcement.training import (
        CurvePoint,
        TrainingProgress,
        draw_curves,
        read_curve,
        train_reinforcement,
    )
except ModuleNotFoundError as _error:
    raise MissingExtra("Learning by trial", _error.name or "stable_baselines3", "rl") from _error

__all__ = [
    "CurvePoint",
    "LearningEnv",
    "ReinforcementConfig",
    "ReinforcementPolicy",
    "TrainingProgress",
    "draw_curves",
    "policy",
    "read_curve",
    "train_reinforcement",
]
