"""Cameras see what a task is about."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.environment import ObservationConfig
from rlbench_pin.environment.presets import make_environment
from rlbench_pin.tasks import library_names

LEAST, CAMERAS, SIZE = 40, 3, 128
"""So many pixels of a task's things, in so many of the five default cameras, in pictures of this size."""
OTHERS = {"panda", "table", "floor", "ceiling", *(f"wall_{side}" for side in ("front", "back", "left", "right"))}


@pytest.mark.simulation
@pytest.mark.parametrize("name", library_names())
def test_three_cameras_see_the_things_of_a_task(name: str) -> None:
    """Each of three cameras sees forty pixels of them at the reset, whatever the arm hides."""
    config = ObservationConfig()
    config.set_all(False)
    for camera in config.cameras().values():
        camera.mask, camera.image_size = True, (SIZE, SIZE)
    with make_environment(config) as environment:
        task = environment.get_task(name)
        for seed in range(2):
            _, frame = task.reset(seed=seed, variation=0)
            names = frame.misc["mask_names"]
            things = [number for number, label in names.items() if label.split("/")[0] not in OTHERS]
            masks = [getattr(frame, f"{camera}_mask") for camera in config.cameras()]
            assert sum(np.isin(mask, things).sum() >= LEAST for mask in masks) >= CAMERAS
