"""Draw docs/images/sheets/: the events of a demonstration of each task, and docs/images/looks.jpg: appearance settings.

Usage: python scripts/contact_sheets.py [TASK ...] [--variation N] [--seed N] [--robot NAME]
With another arm than the Panda the sheets are smaller, and docs/images/arms/NAME_TASK.jpg.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from PIL import Image

from rlbench_pin.checking.sheets import SIZE as SHEET_SIZE
from rlbench_pin.checking.sheets import contact_sheet, demo_sheet
from rlbench_pin.environment import (
    Discrete,
    Environment,
    JointPosition,
    MoveArmThenGripper,
    ObservationConfig,
    RandomizeEvery,
    VisualRandomizationConfig,
)
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.observation import CAMERAS
from rlbench_pin.robot import DEFAULT_ROBOT
from rlbench_pin.tasks import find_task, task_names

IMAGES = Path(__file__).resolve().parents[1] / "docs" / "images"
SIZE = 144
"""Side of an image of `looks` [px]."""
ARM_SIZE = 240
"""Side of the task view of sheets with another arm than the Panda [px]."""


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
            frame = environment.get_task("stack_blocks").reset(seed=seed, variation=0)[1]
        frames.append([getattr(frame, f"{camera}_rgb") for camera in CAMERAS])
    columns = [camera.replace("_", " ") for camera in CAMERAS]
    return contact_sheet(frames, rows, columns, "Looks", "stack_blocks; colours that a task gave stay")


def main() -> None:
    """Draw the sheets of some or all tasks."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tasks", nargs="*")
    parser.add_argument("--variation", type=int, default=0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--robot", default=DEFAULT_ROBOT, help="name of the arm")
    options = parser.parse_args()
    other = options.robot != DEFAULT_ROBOT
    folder, size = (IMAGES / "arms", ARM_SIZE) if other else (IMAGES / "sheets", SHEET_SIZE)
    folder.mkdir(parents=True, exist_ok=True)
    for name in options.tasks or task_names():
        began = time.perf_counter()
        try:
            sheet, _ = demo_sheet(find_task(name), options.seed, options.variation, size=size, robot=options.robot)
        except RlbenchPinError as error:
            print(f"{name}: {error}")
            continue
        file = folder / (f"{options.robot}_{name}.jpg" if other else f"{name}.jpg")
        sheet.save(file, quality=74, optimize=True)
        print(
            f"{file}: {sheet.width} x {sheet.height} px, {file.stat().st_size // 1000} kB, {time.perf_counter() - began:.0f} s",
            flush=True,
        )
    if not options.tasks and not other:
        looks().save(IMAGES / "looks.jpg", quality=76, optimize=True)


if __name__ == "__main__":
    main()
