"""What the browser shows of a task that is being edited."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.builder.view.window import Window
from rlbench_pin.front_door import front_door

__all__ = ["Window"]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
