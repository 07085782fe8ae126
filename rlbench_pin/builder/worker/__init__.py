"""The world of the edited task in a worker process; if it hangs or crashes, the builder keeps running."""

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
