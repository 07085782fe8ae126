"""Write docs/gallery.md and docs/images/gallery/: start and result of every task of the library, cut from its contact sheet.

Usage: python scripts/gallery.py    after `python scripts/contact_sheets.py`
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from PIL import Image

from rlbench_pin.checking.sheets import first_and_last
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.tasks import library_names

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGE, SHEETS, IMAGES = DOCS / "gallery.md", DOCS / "images" / "sheets", DOCS / "images" / "gallery"
COLUMNS, SIZE, GAP = 2, 320, 4
HEAD = """# Gallery

The {count} tasks of the library, each with seed 0 and variation 0, and a sentence that asks for it. On the left is the start;
on the right is the result 1 s after success, without the arm, or with the gripper that holds an object.
Each image links to the task's contact sheet: its events from a camera aimed at the task, the five cameras of observations and
`clear_robot_side`.
[All tasks on one sheet](images/tasks.jpg).
`rlbench-pin view TASK` draws the sheet of any task, `rlbench-pin video TASK` films it. Written by `python scripts/gallery.py`.

"""


def draw(name: str) -> None:
    """Write the image of a task, its start beside its result."""
    image = Image.new("RGB", (2 * SIZE + GAP, SIZE), (255, 255, 255))
    with Image.open(SHEETS / f"{name}.jpg") as sheet:
        for k, view in enumerate(first_and_last(sheet)):
            image.paste(view.resize((SIZE, SIZE), Image.Resampling.LANCZOS), (k * (SIZE + GAP), 0))
    image.save(IMAGES / f"{name}.jpg", quality=80, optimize=True)


def entry(name: str, instruction: str) -> str:
    """Return the cell of a task."""
    return f"[![{name}](images/gallery/{name}.jpg)](images/sheets/{name}.jpg)<br>`{name}`<br>{instruction}"


def page(instructions: Mapping[str, str]) -> str:
    """Return the whole page."""
    cells = [entry(name, instructions[name]) for name in instructions]
    cells += [""] * (-len(cells) % COLUMNS)
    rows = [cells[i : i + COLUMNS] for i in range(0, len(cells), COLUMNS)]
    lines = [["" for _ in range(COLUMNS)], ["---" for _ in range(COLUMNS)], *rows]
    return HEAD.format(count=len(instructions)) + "".join(f"| {' | '.join(line)} |\n" for line in lines)


def main() -> None:
    """Write all images and the page."""
    IMAGES.mkdir(parents=True, exist_ok=True)
    instructions = {}
    with make_environment(low_dim_config()) as environment:
        for name in library_names():
            draw(name)
            instructions[name] = environment.get_task(name).reset(seed=0, variation=0)[0][0]
    PAGE.write_text(page(instructions), encoding="utf-8")


if __name__ == "__main__":
    main()
