"""Key-frame cloning: the next tip pose from votes of the points of a cloud, learned from recorded demonstrations."""

from __future__ import annotations

from rlbench_pin.errors import MissingExtra

try:
    from rlbench_pin.baselines.key_frames.policy import KeyFramePolicy, policy
    from rlbench_pin.baselines.key_frames.training import KeyFrameLearner, load_key_frames, train_key_frames
except ModuleNotFoundError as _error:
    raise MissingExtra("Key-frame cloning", _error.name or "torch", "learn") from _error

__all__ = ["KeyFrameLearner", "KeyFramePolicy", "load_key_frames", "policy", "train_key_frames"]
