"""The page that the browser shows of the edited task."""

from __future__ import annotations

from rlbench_pin.builder.view.window import Window

__all__ = ["Window"]
