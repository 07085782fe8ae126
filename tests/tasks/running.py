"""Tasks of the library in their worlds."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from rlbench_pin.errors import BoundaryError
from rlbench_pin.robot.description import robot_description
from rlbench_pin.sim import World
from rlbench_pin.tasks import Task, task_class, task_scene


@contextmanager
def running(name: str) -> Iterator[Task]:
    """A task in its world, set up."""
    with World(task_scene(task_class(name)), robot_description("panda")) as world:
        task = task_class(name)(world)
        task.init_task()
        yield task


def begin(task: Task, variation: int = 0, seed: int = 0) -> list[str]:
    """Begin an episode at the nominal place; a crowded draw is drawn again, as a reset does."""
    generator = np.random.default_rng(seed)
    for _ in range(5):
        try:
            return task.begin_episode(variation, generator)
        except BoundaryError:
            continue
    raise AssertionError("five draws in a row found no place")


def colors(task: Task, *names: str) -> list[tuple[float, ...]]:
    """Colours of bodies."""
    return [task.world.body(n).color[:3] for n in names]
