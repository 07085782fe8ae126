"""The classical baseline: geometry from RGB-D, known models and recipes of skills, without learning or simulator state."""

from __future__ import annotations

import importlib.util

from rlbench_pin.baselines.classical.policy import ClassicalPolicy, policy
from rlbench_pin.baselines.classical.recipes import TASKS
from rlbench_pin.errors import MissingExtra

if importlib.util.find_spec("small_gicp") is None:
    raise MissingExtra("The classical baseline", "small_gicp", "classical")

__all__ = ["TASKS", "ClassicalPolicy", "policy"]
