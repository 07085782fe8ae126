"""One demonstration as a contact sheet: the five cameras and the clear view at the reset and at moments up to the end."""

from __future__ import annotations

import numpy as np
from PIL import Image

from rlbench_pin.checking.pages.sheet import contact_sheet
from rlbench_pin.environment import ObservationConfig, TaskEnvironment
from rlbench_pin.environment.presets import clear_view, low_dim_config, make_environment
from rlbench_pin.errors import DemoError
from rlbench_pin.observation import Demo, Observation
from rlbench_pin.tasks import Task

MOMENTS = 5


def demo_sheet(
    task: type[Task], seed: int, variation: int = 0, *, attempt: int | None = None, size: int = 256
) -> tuple[Image.Image, str]:
    """Draw a demonstration, and return the picture and the name of the task.

    Args:
        task: Class of the task.
        seed: Seed of the episode.
        variation: Variation of the task.
        attempt: Which try of the seed; None takes the first that succeeds.
        size: Side of each picture [px].

    Raises:
        DemoError: The demonstration fails.
    """
    config = sheet_config(size)
    with make_environment(config) as environment:
        task_environment = environment.get_task(task)
        demo = _demonstrate(task_environment, seed, variation, attempt)
        frames = moments(task_environment, demo, config)
    times = ["reset", *(f"t = {moment:.1f} s" for moment in list(frames)[1:])]
    pictures = [[getattr(obs, f"{camera}_rgb") for camera in config.all_cameras()] for obs in frames.values()]
    names = [camera.replace("_", " ") for camera in config.all_cameras()]
    subtitle = f"variation {demo.variation_number}, seed {seed}, {len(demo)} frames"
    return contact_sheet(pictures, times, names, f"{demo.task_name}: {demo.instructions[0]}", subtitle), demo.task_name


def sheet_config(size: int) -> ObservationConfig:
    """Return the five cameras and the clear view, of `size` px and with smooth edges, all off: `moments` turns them on."""
    config = low_dim_config()
    config.extra_cameras = clear_view((size, size))
    for camera in config.all_cameras().values():
        camera.set_all(False)
        camera.image_size, camera.antialiasing = (size, size), True
    return config


def _demonstrate(task_environment: TaskEnvironment, seed: int, variation: int, attempt: int | None) -> Demo:
    if attempt is None:
        task_environment.set_variation(variation)
        return task_environment.get_demos(1, live_demos=True, seed=seed)[0]
    outcome = task_environment.try_demo(seed=seed, variation=variation, attempt=attempt)
    if outcome.demo is None:
        raise DemoError(
            f"Seed {seed}, attempt {attempt} of '{task_environment.get_name()}' does not succeed again: {outcome.cause}",
            task_environment.task,
        )
    return outcome.demo


def moments(task: TaskEnvironment, demo: Demo, config: ObservationConfig, count: int = MOMENTS) -> dict[float, Observation]:
    """Play a demonstration again and look through all cameras at `count` frames of it, first and last among them.

    Playing it twice is cheaper than taking every picture, and the second time goes exactly as the first.

    Returns:
        Time since the reset [s] -> what is seen then.
    """
    wanted = set(np.linspace(0, len(demo) - 1, count).round().astype(int).tolist())
    seen: dict[float, Observation] = {}
    frame, began = 0, 0.0

    def look(_: Observation) -> None:
        nonlocal frame, began
        began = began if frame else task.world.time
        if frame in wanted:
            for camera in config.all_cameras().values():
                camera.rgb = True
            seen[task.world.time - began] = task.get_observation()
            for camera in config.all_cameras().values():
                camera.set_all(False)
        frame += 1

    assert demo.seed is not None
    task.try_demo(seed=demo.seed, variation=demo.variation_number, attempt=demo.attempt, on_frame=look)
    return seen
