"""The observation of one instant."""

from __future__ import annotations

from rlbench_pin.observation import Observation

__all__ = ["Observation"]
