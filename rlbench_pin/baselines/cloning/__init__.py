"""Behaviour cloning: chunks of joint commands, learned from recorded demonstrations, from state or from images."""

from __future__ import annotations

from rlbench_pin.errors import MissingExtra

try:
    from rlbench_pin.baselines.cloning.policy import CloningPolicy, policy
    from rlbench_pin.baselines.cloning.training import ChunkLearner, ModelFileError, TrainConfig, load_cloning, train_cloning
except ModuleNotFoundError as _error:
    raise MissingExtra("Cloning", _error.name or "torch", "learn") from _error

__all__ = ["ChunkLearner", "CloningPolicy", "ModelFileError", "TrainConfig", "load_cloning", "policy", "train_cloning"]
