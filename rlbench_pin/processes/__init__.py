"""Jobs in this process, in processes of this machine or, by `ray_engine.RayEngine`, in a Ray cluster."""

from rlbench_pin.processes.jobs import (
    Engine,
    GivenUp,
    Journal,
    JournalInUse,
    ProcessEngine,
    SerialEngine,
    Worker,
    WorkerDeath,
    WorkersDie,
    exclusive,
    ignore_interrupts,
    run_jobs,
)

__all__ = [
    "Engine",
    "GivenUp",
    "Journal",
    "JournalInUse",
    "ProcessEngine",
    "SerialEngine",
    "Worker",
    "WorkerDeath",
    "WorkersDie",
    "exclusive",
    "ignore_interrupts",
    "run_jobs",
]
