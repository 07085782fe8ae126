"""The world of the task that is being built, in a process of its own: asked by the server, contained when it misbehaves."""

from __future__ import annotations

from rlbench_pin.builder.stage.client import StageClient
from rlbench_pin.builder.stage.faults import NothingOpen, StageBusy, StageClosed, StageFault, StageStopped
from rlbench_pin.builder.stage.limits import StageLimits

__all__ = ["NothingOpen", "StageBusy", "StageClient", "StageClosed", "StageFault", "StageLimits", "StageStopped"]
