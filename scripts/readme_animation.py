"""Draw all tasks of the library side by side: a video of their demonstrations, and an image of their final states.

Usage: python scripts/readme_animation.py [TASK ...] [--out FILE.webp]    docs/images/tasks.webp, and tasks.jpg next to it
All tasks have the same duration in the video, so their speeds differ; the last frame is held for a moment.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from PIL import Image

from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.recording.video import Clip, grid_frames, points_to_show
from rlbench_pin.sim import framed
from rlbench_pin.tasks import library_names

OUT = Path(__file__).resolve().parents[1] / "docs" / "images" / "tasks.webp"
CELL, PICTURES, STILL, PAUSE, SEED, QUALITY = (150, 140), 44, 8, 110, 0, 40
"""Size of a task [px], images of a demonstration, of its end, time of each [ms], seed, quality of WebP."""
LIMIT = 4_500_000
"""Bytes that the file may have."""
EYE = (0.75, 1.45, 1.95)
"""Ahead of the robot's left shoulder [m]."""


def clip_of(name: str) -> Clip:
    """Play a demonstration of a task and keep images at equal intervals, first and last among them."""
    clip = Clip()
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task(name)
        demo = task.get_demos(1, live_demos=True, seed=SEED)[0]
        view = framed(EYE, points_to_show(task.world), (2 * CELL[0], 2 * CELL[1]))
        wanted = np.linspace(0, len(demo) - 1, PICTURES).round().astype(int).tolist()
        frame = 0

        def look(_: object) -> None:
            nonlocal frame
            shown = wanted.count(frame)
            if shown:
                small = Image.fromarray(task.world.renderer.image(view)).resize(CELL, Image.Resampling.LANCZOS)
                for _ in range(shown):
                    clip.add(np.asarray(small))
            frame += 1

        task.try_demo(seed=SEED, attempt=demo.attempt, on_frame=look)
    for _ in range(STILL):
        clip.add(np.asarray(clip.frame(len(clip) - 1)))
    return clip


def main() -> None:
    """Film some or all tasks and write the animation."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tasks", nargs="*")
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args()
    clips = {}
    for name in options.tasks or library_names():
        clips[name] = clip_of(name)
        print(f"{name}: {len(clips[name])} images", flush=True)
    first, *rest = [Image.fromarray(image) for image in grid_frames(clips, CELL)]
    options.out.parent.mkdir(parents=True, exist_ok=True)
    first.save(options.out, save_all=True, append_images=rest, duration=PAUSE, loop=0, quality=QUALITY, method=4)
    rest[-1].save(options.out.with_suffix(".jpg"), quality=82, optimize=True)
    size = options.out.stat().st_size
    print(options.out, size // 1024, "KiB")
    if size > LIMIT:
        raise SystemExit(f"{options.out} is larger than {LIMIT} bytes: lower QUALITY, PICTURES or CELL.")


if __name__ == "__main__":
    main()
