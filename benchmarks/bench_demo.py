"""A whole demonstration without images, reset included. Goal: at least ten times faster than real time."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np
from harness import Result, main, summary, velocity_environment

from rlbench_pin.tasks import task_names

SEEDS = 10


def benchmark(tasks: Sequence[str] = (), seeds: int = SEEDS) -> list[Result]:
    """Demonstrate each task and set processor time beside simulated time."""
    return [_task(name, seeds) for name in tasks or task_names()]


def _task(name: str, seeds: int) -> Result:
    spent, simulated, planning = [], [], []
    with velocity_environment() as environment:
        task = environment.get_task(name)
        task.try_demo(seed=0)
        for seed in range(seeds):
            began = time.process_time()
            outcome = task.try_demo(seed=seed, variation=seed % task.variation_count())
            spent.append(time.process_time() - began)
            simulated.append(outcome.duration)
            planning.append(outcome.planning_time)
    speed = float(np.sum(simulated) / np.sum(spent))
    share = float(np.sum(planning) / np.sum(spent))
    note = f"{np.median(simulated):.1f} s simulated, {speed:.0f} x real time, {share:.0%} of it planning"
    return summary(f"demo {name}", spent, note, times_real_time=speed, planning_share=share)


if __name__ == "__main__":
    main(__doc__, benchmark)
