"""One demonstration."""

from __future__ import annotations

from rlbench_pin.observation import Demo

__all__ = ["Demo"]
