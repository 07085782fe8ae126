"""The world of the edited task in a worker process, which may hang or crash without harm to the builder."""

from __future__ import annotations

from rlbench_pin.builder.worker.client import WorkerClient
from rlbench_pin.builder.worker.process import (
    NothingOpen,
    WorkerBusy,
    WorkerClosed,
    WorkerFault,
    WorkerLimits,
    WorkerStopped,
)

__all__ = ["NothingOpen", "WorkerBusy", "WorkerClient", "WorkerClosed", "WorkerFault", "WorkerLimits", "WorkerStopped"]
