"""The viewer without an editor: tasks, stored demonstrations, and policies while they are evaluated."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.errors import MissingExtra
from rlbench_pin.front_door import front_door

try:
    from rlbench_pin.builder.playback.live.dataset_view import DatasetView
    from rlbench_pin.builder.playback.live.evaluation_view import EvaluationView, LiveRunner
    from rlbench_pin.builder.playback.live.live_view import LiveView
    from rlbench_pin.builder.playback.live.task_view import TaskView
except ModuleNotFoundError as _error:
    if _error.name is None or _error.name.partition(".")[0] not in ("viser", "trimesh"):
        raise
    raise MissingExtra("The live view", _error.name, "builder") from _error

__all__ = ["DatasetView", "EvaluationView", "LiveRunner", "LiveView", "TaskView"]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
