"""Draw docs/images/gallery/: every task of the library late in a demonstration, and write docs/gallery.md, which shows them.

Usage: python scripts/gallery.py [TASK ...]    some tasks: their images and their entries anew, the others as they are
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path

import numpy as np
from PIL import Image

from rlbench_pin.environment.presets import clear_view, low_dim_config, make_environment
from rlbench_pin.robot.description import DEFAULT_ROBOT, robot_description
from rlbench_pin.sim import CameraView, look_at
from rlbench_pin.tasks import library_names

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGE, PICTURES = DOCS / "gallery.md", DOCS / "images" / "gallery"
COLUMNS, SIZE, SEED = 2, 320, 0
MOMENTS = {"put_rubbish_in_bin": 0.72, "meat_off_grill": 0.7, "slide_block_to_target": 0.8, "stack_blocks": 0.95}
"""Share of the demonstration that has passed; all of it where none is given."""
VIEW = CameraView(
    pose=look_at((0.0, 1.5, 1.65), (0.18, 0.0, 0.98)), fov=float(np.radians(42.0)), size=(SIZE, SIZE), near=0.05, far=6.0
)
HEAD = """# Gallery

The {count} tasks of the library, each late in a demonstration of seed 0 and variation 0, from the side and from behind the robot
(`clear_robot_side`), with a sentence that asks for it. Each image links to the task's contact sheet: the five cameras and the
three clear views at five moments.
`rlbench-pin view TASK` draws the sheet of any task, `rlbench-pin video TASK` films it. Written by `python scripts/gallery.py`.

"""


def late_in_a_demonstration(name: str) -> tuple[Image.Image, str]:
    """Play a demonstration and return one image of it, from two sides, and its first instruction."""
    shots: list[np.ndarray] = []
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task(name)
        demo = task.get_demos(1, live_demos=True, seed=SEED)[0]
        wanted, frame = round(MOMENTS.get(name, 1.0) * (len(demo) - 1)), 0

        def look(_: object) -> None:
            nonlocal frame
            if frame == wanted:
                behind = clear_view((SIZE, SIZE))["clear_robot_side"].view(task.world, robot_description(DEFAULT_ROBOT))
                shots.extend(task.world.renderer.image(view) for view in (VIEW, behind))
            frame += 1

        assert demo.random_seed is not None
        task.try_demo(seed=demo.random_seed, attempt=demo.attempt, on_frame=look)
    return Image.fromarray(np.concatenate(shots, axis=1)), demo.instructions[0]


def draw(name: str) -> str:
    """Write the image of a task and return its first instruction."""
    image, instruction = late_in_a_demonstration(name)
    PICTURES.mkdir(parents=True, exist_ok=True)
    image.save(PICTURES / f"{name}.jpg", quality=80, optimize=True)
    return instruction


def entry(name: str, instruction: str) -> str:
    """Return the cell of a task."""
    return f"[![{name}](images/gallery/{name}.jpg)](images/sheets/{name}.jpg)<br>`{name}`<br>{instruction}"


def written() -> dict[str, str]:
    """Return the instructions that the page shows now, by task."""
    text = PAGE.read_text(encoding="utf-8") if PAGE.exists() else ""
    return dict(re.findall(r"<br>`(\w+)`<br>([^|]*?) *\|", text))


def page(instructions: dict[str, str]) -> str:
    """Return the whole page."""
    cells = [entry(name, instructions[name]) for name in library_names() if name in instructions]
    cells += [""] * (-len(cells) % COLUMNS)
    rows = [cells[i : i + COLUMNS] for i in range(0, len(cells), COLUMNS)]
    lines = [["" for _ in range(COLUMNS)], ["---" for _ in range(COLUMNS)], *rows]
    return HEAD.format(count=len(instructions)) + "".join(f"| {' | '.join(line)} |\n" for line in lines)


def main() -> None:
    """Draw the images of some or all tasks, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tasks", nargs="*")
    instructions = written()
    for name in parser.parse_args().tasks or library_names():
        instructions[name] = draw(name)
        print(f"{PICTURES / name}.jpg: {instructions[name]}", flush=True)
    PAGE.write_text(page(instructions), encoding="utf-8")


if __name__ == "__main__":
    main()
