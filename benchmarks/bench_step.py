"""State-only steps in joint velocity control on reach_target. Goal: at least 1,000 per second, 50 times real time."""

from __future__ import annotations

import numpy as np
from harness import Result, main, measure, summary, velocity_environment

EPISODES, STEPS = 10, 200


def benchmark(task_name: str = "reach_target") -> list[Result]:
    """Step with small random velocities over several episodes; then the parts of a step alone."""
    repeats = STEPS
    with velocity_environment() as environment:
        task = environment.get_task(task_name)
        rng = np.random.default_rng(0)
        actions = np.column_stack([rng.uniform(-0.3, 0.3, (STEPS, 7)), np.ones(STEPS)])
        steps: list[float] = []
        for episode in range(EPISODES):
            task.reset(seed=episode)
            steps += measure(lambda i: task.step(actions[i]), STEPS, warm_up=5)
        physics = measure(lambda i: task.world.step(), repeats, warm_up=50)
        observe = measure(lambda i: task.get_observation(), repeats, warm_up=50)
        judge = measure(lambda i: task.task.success(), repeats, warm_up=50)
    rate = 1.0 / float(np.mean(steps))
    note = f"{rate:.0f} steps/s, {rate * task.world.control_dt:.0f} x real time"
    return [
        summary(f"step {task_name}, joint velocity", steps, note, steps_per_second=rate),
        summary("  of which physics", physics),
        summary("  of which observation", observe),
        summary("  of which success", judge),
    ]


if __name__ == "__main__":
    main(__doc__, benchmark)
