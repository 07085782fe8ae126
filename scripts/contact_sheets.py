"""Draw docs/images/sheets/: every task as all cameras see a demonstration, and docs/images/looks.jpg of appearance settings.

Usage: python scripts/contact_sheets.py [TASK ...] [--variation N] [--seed N]
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from rlbench_pin.checking.images import contact_sheet, moments, sheet_config
from rlbench_pin.environment import (
    Discrete,
    Environment,
    JointPosition,
    MoveArmThenGripper,
    ObservationConfig,
    RandomizeEvery,
    VisualRandomizationConfig,
)
from rlbench_pin.environment.presets import make_environment
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.observation import CAMERAS, Observation
from rlbench_pin.tasks import task_names

IMAGES = Path(__file__).resolve().parents[1] / "docs" / "images"
SIZE, MOMENTS = 144, 5


def sheet_of(name: str, variation: int, seed: int) -> Image.Image:
    """All cameras at the reset, at three moments of a demonstration and at its end."""
    config = sheet_config(SIZE)
    with make_environment(config) as environment:
        task = environment.get_task(name)
        task.set_variation(variation)
        demo = task.get_demos(1, live_demos=True, seed=seed)[0]
        frames = moments(task, demo, config, MOMENTS)
    rows = ["reset", *(f"t = {moment:.1f} s" for moment in list(frames)[1:-1]), "end"]
    return _sheet(
        list(frames.values()),
        list(config.all_cameras()),
        rows,
        f"{name}: {demo.instructions[0]}",
        f"variation {variation}, seed {seed}",
    )


def _sheet(frames: list[Observation], cameras: Sequence[str], rows: list[str], title: str, subtitle: str) -> Image.Image:
    pictures = [[getattr(frame, f"{camera}_rgb") for camera in cameras] for frame in frames]
    return contact_sheet(pictures, rows, [camera.replace("_", " ") for camera in cameras], title, subtitle)


def looks() -> Image.Image:
    """One episode without shadows, with default appearance, and randomized twice."""
    frames, rows = [], ["opengl", "opengl3", "randomized", "randomized"]
    for row, seed in zip(rows, (3, 3, 3, 4)):
        config = ObservationConfig()
        for camera in config.cameras().values():
            camera.image_size, camera.antialiasing = (SIZE, SIZE), True
            camera.render_mode = "opengl" if row == "opengl" else "opengl3"
        random = row == "randomized"
        with Environment(
            MoveArmThenGripper(JointPosition(), Discrete()),
            obs_config=config,
            randomize_every=RandomizeEvery.EPISODE if random else None,
            visual_randomization_config=VisualRandomizationConfig() if random else None,
        ) as environment:
            frames.append(environment.get_task("stack_blocks").reset(seed=seed, variation=0)[1])
    return _sheet(frames, CAMERAS, rows, "Looks", "stack_blocks; colours that a task gave stay")


def main() -> None:
    """Draw the sheets of some or all tasks."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tasks", nargs="*")
    parser.add_argument("--variation", type=int, default=0)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    folder = IMAGES / "sheets"
    folder.mkdir(parents=True, exist_ok=True)
    for name in options.tasks or task_names():
        try:
            sheet = sheet_of(name, options.variation, options.seed)
        except RlbenchPinError as error:
            print(f"{name}: {error}")
            continue
        sheet.save(folder / f"{name}.jpg", quality=76, optimize=True)
        print(folder / f"{name}.jpg", np.asarray(sheet).shape)
    if not options.tasks:
        looks().save(IMAGES / "looks.jpg", quality=76, optimize=True)


if __name__ == "__main__":
    main()
