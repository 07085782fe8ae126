"""Key-frame cloning: the next tip pose from a point cloud, by votes of its points, learned from recorded demonstrations."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.errors import MissingExtra
from rlbench_pin.front_door import front_door

try:
    from rlbench_pin.evaluation.baselines.key_frames.learner import KeyFrameLearner, load_key_frames, train_key_frames
    from rlbench_pin.evaluation.baselines.key_frames.policy import KeyFramePolicy, policy
except ModuleNotFoundError as _error:
    raise MissingExtra("Key-frame cloning", _error.name or "torch", "learn") from _error

__all__ = ["KeyFrameLearner", "KeyFramePolicy", "load_key_frames", "policy", "train_key_frames"]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
