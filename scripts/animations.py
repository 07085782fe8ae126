"""Film a demonstration of every task: one video for each task page, and one video of all tasks side by side for README.md.

Usage: python scripts/animations.py [TASK ...]

Writes docs/images/videos/TASK.webp, and for the whole library docs/images/tasks.webp with its last frame in tasks.jpg. The
script keeps an existing video of a task: delete the file to film the task again. In the video of all tasks, every demonstration
has the same duration, so their speeds differ; the last frame stays for a moment.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from PIL import Image, ImageSequence
from tqdm import tqdm

from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.recording.video import Clip, grid_frames, points_to_show
from rlbench_pin.sim import framed
from rlbench_pin.tasks import library_names

IMAGES = Path(__file__).resolve().parents[1] / "docs" / "images"
VIDEOS, SHEET = IMAGES / "videos", IMAGES / "tasks.webp"
SIZE, CELL = (300, 280), (132, 123)
"""Size of a video of one task, and of a task in the video of all [px]."""
FRAMES, LAST = 40, 8
"""Number of frames of a demonstration, and of its last state."""
PAUSE, SEED = 110, 0
"""Duration of a frame [ms]; seed of the demonstrations."""
QUALITY, SHEET_QUALITY = 45, 38
"""Qualities of WebP, of videos of tasks and of the video of all."""
LIMIT = 4_500_000
"""Maximum size of the video of all tasks [bytes]."""
EYE = (0.75, 1.45, 1.95)
"""Position of the camera, in front of the left shoulder of the robot [m]."""


def film(name: str) -> list[Image.Image]:
    """Play a demonstration of a task and return frames at equal intervals, the first and the last one included."""
    frames: list[Image.Image] = []
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task(name)
        demo = task.get_demos(1, live_demos=True, seed=SEED)[0]
        view = framed(EYE, points_to_show(task.world), (2 * SIZE[0], 2 * SIZE[1]))
        wanted = np.linspace(0, len(demo) - 1, FRAMES).round().astype(int).tolist()
        tick = 0

        def look(_: object) -> None:
            nonlocal tick
            if shown := wanted.count(tick):
                image = Image.fromarray(task.world.renderer.image(view)).resize(SIZE, Image.Resampling.LANCZOS)
                frames.extend([image] * shown)
            tick += 1

        task.try_demo(seed=SEED, attempt=demo.attempt, on_frame=look)
    return frames + [frames[-1]] * LAST


def write(path: Path, frames: list[Image.Image], quality: int) -> None:
    """Write an animated WebP file that repeats."""
    path.parent.mkdir(parents=True, exist_ok=True)
    first, *rest = frames
    first.save(path, save_all=True, append_images=rest, duration=PAUSE, loop=0, quality=quality, method=4)


def cell_clip(path: Path) -> Clip:
    """Return the video of a task in the size of a cell. WebP joins equal frames; they are repeated by their duration."""
    clip = Clip()
    with Image.open(path) as video:
        for frame in ImageSequence.Iterator(video):
            small = np.asarray(frame.convert("RGB").resize(CELL, Image.Resampling.LANCZOS))
            for _ in range(max(1, round(frame.info.get("duration", PAUSE) / PAUSE))):
                clip.add(small)
    return clip


def main() -> None:
    """Film tasks; then write the video of all tasks, if no task is named."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tasks", nargs="*", metavar="TASK", help="tasks to film (default: all, and the video of all)")
    options = parser.parse_args()
    names = library_names()
    for name in tqdm(options.tasks or [name for name in names if not (VIDEOS / f"{name}.webp").is_file()], unit="task"):
        write(VIDEOS / f"{name}.webp", film(name), QUALITY)
    if options.tasks:
        return
    frames = [Image.fromarray(image) for image in grid_frames({name: cell_clip(VIDEOS / f"{name}.webp") for name in names}, CELL)]
    write(SHEET, frames, SHEET_QUALITY)
    frames[-1].save(SHEET.with_suffix(".jpg"), quality=82, optimize=True)
    if (size := SHEET.stat().st_size) > LIMIT:
        raise SystemExit(f"{SHEET} has {size} bytes, more than {LIMIT}: lower SHEET_QUALITY, FRAMES or CELL.")


if __name__ == "__main__":
    main()
