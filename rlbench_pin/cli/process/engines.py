"""The engine that a command line names."""

from __future__ import annotations

import importlib
from collections.abc import Callable

from rlbench_pin.cli.process.words import EngineName
from rlbench_pin.processes import Engine, ProcessEngine, SerialEngine


def make_engine(name: EngineName, workers: int) -> Engine:
    """Return what does the work.

    Raises:
        MissingExtra: Ray is not installed.
    """
    if name == "processes":
        return ProcessEngine(workers) if workers else SerialEngine()
    make: Callable[[int], Engine] = importlib.import_module("rlbench_pin.processes.ray_engine").RayEngine
    return make(max(1, workers))
