"""The classical baseline: geometry from RGB-D, known models, recipes of skills. No learning and no state of the simulator."""

from __future__ import annotations

from rlbench_pin.baselines.classical.policy import ClassicalPolicy, policy
from rlbench_pin.baselines.classical.recipes import TASKS

__all__ = ["TASKS", "ClassicalPolicy", "policy"]
