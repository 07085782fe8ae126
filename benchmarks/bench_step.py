"""State-only steps in joint velocity control, beside panda-gym. Goal: twice as fast as its reach, 1.5 times its pick and place.

Compared are simulated seconds per second of processor time, each with its own physics: the notes say what one step simulates.
"""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable

import numpy as np
from harness import Result, main, measure, summary, velocity_environment

from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.sim.client import PASSES

EPISODES, STEPS = 10, 200
PEERS = {"reach_target": "PandaReach-v3", "stack_blocks": "PandaPickAndPlace-v3"}
"""Task of ours -> environment of panda-gym of about the same size."""


def benchmark(task_name: str = "reach_target") -> list[Result]:
    """Step with small random velocities over several episodes; then the parts of a step alone; then the same with the peers."""
    results = _ours(task_name)
    if task_name != "stack_blocks":
        results += _ours("stack_blocks")
    return results + _peers()


def _ours(task_name: str) -> list[Result]:
    with velocity_environment() as environment:
        task = environment.get_task(task_name)
        rng = np.random.default_rng(0)
        actions = np.column_stack([rng.uniform(-0.3, 0.3, (STEPS, 7)), np.ones(STEPS)])
        steps: list[float] = []
        for episode in range(EPISODES):
            task.reset(seed=episode)
            steps += [_processor_time(lambda action=action: task.step(action)) for action in actions]
        return [_summary(task_name, task, steps), *_parts(task)]


def _processor_time(operation: Callable[[], object]) -> float:
    began = time.process_time()
    operation()
    return time.process_time() - began


def _summary(task_name: str, task: TaskEnvironment, steps: list[float]) -> Result:
    world = task.world
    physics = f"{round(world.control_dt / world.timestep)} x {1e3 * world.timestep:.2f} ms, at most {PASSES} solver iterations"
    return _result(f"step {task_name}, joint velocity", steps, world.control_dt, physics)


def _result(name: str, steps: list[float], dt: float, physics: str) -> Result:
    """Sum up steps by their median, which other programs on the machine disturb least."""
    rate = 1.0 / float(np.median(steps))
    note = f"{rate:.0f} steps/s, {rate * dt:.0f} x real time, a step is {physics}"
    return summary(name, steps, note, steps_per_second=rate, times_real_time=rate * dt)


def _parts(task: TaskEnvironment) -> list[Result]:
    return [
        summary("  of which physics", measure(lambda i: task.world.step(), STEPS, warm_up=50)),
        summary("  of which observation", measure(lambda i: task.get_observation(), STEPS, warm_up=50)),
        summary("  of which success", measure(lambda i: task.task.success(), STEPS, warm_up=50)),
    ]


def _peers() -> list[Result]:
    """Step the environments of panda-gym with random actions; nothing where it is not installed."""
    try:
        importlib.import_module("panda_gym")
    except ImportError:
        print("panda-gym is not installed, so that its environments are left out: pip install -e '.[peers]'")
        return []
    return [_peer(name) for name in PEERS.values()]


def _peer(name: str) -> Result:
    import gymnasium

    environment = gymnasium.make(name)
    sim = environment.unwrapped.sim  # type: ignore[attr-defined]
    environment.action_space.seed(0)
    steps: list[float] = []
    for episode in range(EPISODES):
        environment.reset(seed=episode)
        actions = [environment.action_space.sample() for _ in range(STEPS)]
        steps += [_processor_time(lambda action=action: environment.unwrapped.step(action)) for action in actions]
    environment.close()
    return _result(f"panda-gym {name}", steps, sim.dt, f"{sim.n_substeps} x {1e3 * sim.timestep:.2f} ms, 50 solver iterations")


if __name__ == "__main__":
    main(__doc__, benchmark)
