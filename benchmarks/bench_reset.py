"""How long a reset takes, without images, task by task. Goal: median below 30 ms."""

from __future__ import annotations

from collections.abc import Sequence

from harness import Result, main, measure, summary, velocity_environment

from rlbench_pin.tasks import task_names

REPEATS = 50


def benchmark(tasks: Sequence[str] = (), repeats: int = REPEATS) -> list[Result]:
    """Reset each task with different seeds, over its variations."""
    results = []
    for name in tasks or task_names():
        with velocity_environment() as environment:
            task = environment.get_task(name)
            task.set_variation(-1)
            results.append(summary(f"reset {name}", measure(lambda i: task.reset(seed=i), repeats)))  # noqa: B023
    return results


if __name__ == "__main__":
    main(__doc__, benchmark)
