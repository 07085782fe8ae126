"""The classical baseline: geometry from RGB-D, known models, recipes of skills. No learning and no state of the simulator."""

from __future__ import annotations

from rlbench_pin.evaluation.baselines.classical.policy import ClassicalPolicy, policy

__all__ = ["ClassicalPolicy", "policy"]
