"""Draw docs/images/tasks.jpg: every task of the library late in a demonstration, seen from the side."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from rlbench_pin.environment.observations.cameras import look_at
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.recording.film import side_picture
from rlbench_pin.sim import CameraView
from rlbench_pin.tasks import library_names

OUT = Path(__file__).resolve().parents[1] / "docs" / "images" / "tasks.jpg"
COLUMNS, CELL, GAP, SEED = 5, (240, 220), 6, 0
MOMENTS = {"put_rubbish_in_bin": 0.72, "meat_off_grill": 0.7, "slide_block_to_target": 0.8, "stack_blocks": 0.95}
"""Share of the demonstration that has passed; all of it where none is given."""
VIEW = CameraView(
    pose=look_at((0.0, 1.5, 1.65), (0.18, 0.0, 0.98)), fov=float(np.radians(42.0)), size=(480, 440), near=0.05, far=6.0
)


def late_in_a_demonstration(name: str) -> tuple[Image.Image, str]:
    """Play a demonstration and return one picture of it, and its first instruction."""
    shots: list[np.ndarray] = []
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task(name)
        demo = task.get_demos(1, live_demos=True, seed=SEED)[0]
        wanted, frame = round(MOMENTS.get(name, 1.0) * (len(demo) - 1)), 0

        def look(_: object) -> None:
            nonlocal frame
            if frame == wanted:
                shots.append(side_picture(task.world, VIEW))
            frame += 1

        assert demo.random_seed is not None
        task.try_demo(seed=demo.random_seed, attempt=demo.attempt, on_frame=look)
    return Image.fromarray(shots[0]), demo.instructions[0]


def picture(name: str) -> Image.Image:
    """Return a small picture with the task's name."""
    image = late_in_a_demonstration(name)[0].resize(CELL, Image.Resampling.LANCZOS)
    ImageDraw.Draw(image).text((6, 4), name.replace("_", " "), fill=(255, 255, 255), font=ImageFont.load_default(13))
    return image


def main() -> None:
    """Lay all pictures out."""
    names = library_names()
    rows = -(-len(names) // COLUMNS)
    size = (COLUMNS * (CELL[0] + GAP) - GAP, rows * (CELL[1] + GAP) - GAP)
    sheet = Image.new("RGB", size, (255, 255, 255))
    for i, name in enumerate(names):
        sheet.paste(picture(name), ((i % COLUMNS) * (CELL[0] + GAP), (i // COLUMNS) * (CELL[1] + GAP)))
    OUT.parent.mkdir(parents=True, exist_ok=True)
    sheet.save(OUT, quality=82, optimize=True)
    print(OUT, OUT.stat().st_size // 1024, "KiB")


if __name__ == "__main__":
    main()
