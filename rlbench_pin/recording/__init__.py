"""Demonstrations by the thousand: recorded, rendered again, converted, replayed and filmed."""

from rlbench_pin.recording.config import RecordConfig
from rlbench_pin.recording.convert import convert_demo, verify
from rlbench_pin.recording.convert_playing import convert_by_playing
from rlbench_pin.recording.record import RecordReport, record

__all__ = ["RecordConfig", "RecordReport", "convert_by_playing", "convert_demo", "record", "verify"]
