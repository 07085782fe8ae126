"""Behaviour cloning: joint commands in chunks, learned from recorded demonstrations, from state or from pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.errors import MissingExtra
from rlbench_pin.front_door import front_door

try:
    from rlbench_pin.evaluation.baselines.cloning.learner import ChunkLearner, load_cloning, train_cloning
    from rlbench_pin.evaluation.baselines.cloning.policy import CloningPolicy, policy
    from rlbench_pin.evaluation.baselines.cloning.storage import ModelFileError
    from rlbench_pin.evaluation.baselines.cloning.training import TrainConfig
except ModuleNotFoundError as _error:
    raise MissingExtra("Cloning", _error.name or "torch", "learn") from _error

__all__ = ["ChunkLearner", "CloningPolicy", "ModelFileError", "TrainConfig", "load_cloning", "policy", "train_cloning"]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
