"""Work that other processes do: any pieces, by any workers, here, in processes of this machine or in a Ray cluster.

`RayEngine` is imported when first used; it needs the extra `ray`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.front_door import front_door
from rlbench_pin.processes.engines import Engine, GivenUp, ProcessEngine, SerialEngine, Worker, WorkerDeath, WorkersDie
from rlbench_pin.processes.interrupts import deaf_to_interrupts

__all__ = [
    "Engine",
    "GivenUp",
    "ProcessEngine",
    "SerialEngine",
    "Worker",
    "WorkerDeath",
    "WorkersDie",
    "deaf_to_interrupts",
]

if TYPE_CHECKING:
    from rlbench_pin.processes.ray_engine import RayEngine as RayEngine
else:
    __getattr__, __dir__ = front_door(__name__, {"RayEngine": "ray_engine"})
