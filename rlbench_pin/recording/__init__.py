"""Demonstrations by the thousand: recorded, rendered again, converted, replayed and filmed.

`RayEngine` is imported when first used; it needs the extra `ray`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.front_door import front_door
from rlbench_pin.processes import Engine, ProcessEngine, SerialEngine
from rlbench_pin.recording.config import PictureConfig, RecordConfig
from rlbench_pin.recording.convert import convert_demo, verify
from rlbench_pin.recording.convert_playing import convert_by_playing
from rlbench_pin.recording.export import export_dataset
from rlbench_pin.recording.film import Film
from rlbench_pin.recording.record import RecordReport, read_recording, record
from rlbench_pin.recording.replay import replay_demo
from rlbench_pin.recording.replay_stored import ReplayResult, replay_stored
from rlbench_pin.recording.rerender import rerender, seeds_of, write_seeds

__all__ = [
    "Engine",
    "Film",
    "PictureConfig",
    "ProcessEngine",
    "RecordConfig",
    "RecordReport",
    "ReplayResult",
    "SerialEngine",
    "convert_by_playing",
    "convert_demo",
    "export_dataset",
    "read_recording",
    "record",
    "replay_demo",
    "replay_stored",
    "rerender",
    "seeds_of",
    "verify",
    "write_seeds",
]

if TYPE_CHECKING:
    from rlbench_pin.processes.ray_engine import RayEngine as RayEngine
else:
    __getattr__, __dir__ = front_door(__name__, {"RayEngine": "rlbench_pin.processes.ray_engine"})
