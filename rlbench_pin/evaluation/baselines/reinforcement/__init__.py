"""Reinforcement learning: PPO and SAC of Stable-Baselines3 from state, with shaped or sparse reward and demonstrations."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.errors import MissingExtra
from rlbench_pin.front_door import front_door

try:
    from rlbench_pin.evaluation.baselines.reinforcement.config import ReinforcementConfig
    from rlbench_pin.evaluation.baselines.reinforcement.curve import CurvePoint, read_curve
    from rlbench_pin.evaluation.baselines.reinforcement.drawing import draw_curves
    from rlbench_pin.evaluation.baselines.reinforcement.policy import ReinforcementPolicy, policy
    from rlbench_pin.evaluation.baselines.reinforcement.training import TrainingProgress, train_reinforcement
    from rlbench_pin.evaluation.baselines.reinforcement.world import LearningEnv
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

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
