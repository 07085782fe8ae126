"""Jobs in this process, in other processes of this machine, or in a Ray cluster (`ray_engine.RayEngine`)."""

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
