"""Cost of factors of generalisation: resets and steps with all factors, against those without. Goal: resets below 1.5 x."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from harness import Result, main, measure, summary

from rlbench_pin.environment import Environment
from rlbench_pin.environment.factors import factor_catalogue
from rlbench_pin.environment.presets import image_config, joint_position_mode, low_dim_config

TASKS = ("open_drawer", "put_rubbish_in_bin", "stack_blocks")
REPEATS = 50
EXCLUDED = ("placement_left", "placement_right")
"""Factors that contradict each other."""


def benchmark(tasks: Sequence[str] = (), repeats: int = REPEATS) -> list[Result]:
    """Reset and step each task without factors, and with all that it can take at their highest level."""
    results = []
    for name in tasks or TASKS:
        found: dict[str, list[float]] = {}
        for cameras, config in (("image", image_config((128, 128), ("front",))), ("no image", low_dim_config())):
            with Environment(joint_position_mode(), obs_config=config, seed=0) as environment:
                task = environment.get_task(name)
                chosen = [f for f in factor_catalogue().values() if not f.why_not(task.task) and f.name not in EXCLUDED]
                for setting, factors in (("none", {}), ("all", {factor.name: len(factor.levels) for factor in chosen})):
                    task.set_factors(factors)
                    found[f"reset, {cameras}, {setting}"] = measure(lambda i: task.reset(seed=i), repeats)  # noqa: B023
                    action = np.append(task.get_observation().joint_positions, 1.0)
                    found[f"step, {cameras}, {setting}"] = measure(lambda _: task.step(action), repeats)  # noqa: B023
        for kind, times in found.items():
            plain = found[kind.replace("all", "none")]
            results.append(summary(f"{name}: {kind}", times, ratio=float(np.median(times) / np.median(plain))))
    return results


if __name__ == "__main__":
    main(__doc__, benchmark)
