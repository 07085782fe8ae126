"""Demonstrations by the thousand: recorded, rendered again, converted, replayed and filmed.

`RayEngine` is imported from `rlbench_pin.recording.ray_engine`, which needs Ray.
"""

from rlbench_pin.recording.config import PictureConfig, RecordConfig
from rlbench_pin.recording.convert import convert_demo, verify
from rlbench_pin.recording.convert_playing import convert_by_playing
from rlbench_pin.recording.engines import Engine, ProcessEngine, SerialEngine
from rlbench_pin.recording.film import Film
from rlbench_pin.recording.record import RecordReport, read_recording, record
from rlbench_pin.recording.replay import replay_demo
from rlbench_pin.recording.rerender import rerender

__all__ = [
    "Engine",
    "Film",
    "PictureConfig",
    "ProcessEngine",
    "RecordConfig",
    "RecordReport",
    "SerialEngine",
    "convert_by_playing",
    "convert_demo",
    "read_recording",
    "record",
    "replay_demo",
    "rerender",
    "verify",
]
