"""Record, rerender, convert and replay demonstrations, and make videos of them. `RayEngine` needs the extra `ray`."""

import importlib
from typing import TYPE_CHECKING

from rlbench_pin.datasets.formats import export_dataset
from rlbench_pin.processes import Engine, ProcessEngine, SerialEngine
from rlbench_pin.recording.config import ImageConfig, RecordConfig, read_recording
from rlbench_pin.recording.convert import convert_by_playing, convert_demo, verify
from rlbench_pin.recording.record import RecordReport, record
from rlbench_pin.recording.replay import ReplayResult, replay_demo, replay_stored
from rlbench_pin.recording.rerender import rerender, seeds_of, write_seeds
from rlbench_pin.recording.video import VideoRecorder

__all__ = [
    "Engine",
    "ImageConfig",
    "ProcessEngine",
    "RecordConfig",
    "RecordReport",
    "ReplayResult",
    "SerialEngine",
    "VideoRecorder",
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

    def __getattr__(name):
        """Import `RayEngine` at its first use."""
        if name != "RayEngine":
            raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
        return importlib.import_module("rlbench_pin.processes.ray_engine").RayEngine
