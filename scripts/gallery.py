"""Draw docs/images/gallery/: every task of the library at work and afterwards, and write docs/gallery.md, which shows them.

Usage: python scripts/gallery.py [TASK ...]    some tasks: their images and their entries anew, the others as they are
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path

from PIL import Image

from rlbench_pin.checking.sheets import demo_moments
from rlbench_pin.tasks import find_task, library_names

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGE, PICTURES = DOCS / "gallery.md", DOCS / "images" / "gallery"
COLUMNS, SIZE, GAP, SEED = 2, 320, 4, 0
HEAD = """# Gallery

The {count} tasks of the library, each in a demonstration of seed 0 and variation 0, with a sentence that asks for it. On the left
the arm is at work; on the right is the result 1 s after success, without the arm, or with the gripper that holds an object.
Each image links to the task's contact sheet: its events from a camera aimed at the task, the five cameras of observations and
`clear_robot_side`.
[All tasks on one sheet](images/tasks.jpg).
`rlbench-pin view TASK` draws the sheet of any task, `rlbench-pin video TASK` films it. Written by `python scripts/gallery.py`.

"""


def draw(name: str) -> str:
    """Write the image of a task, the arm at work beside the result, and return its first instruction."""
    demo, moments = demo_moments(find_task(name), SEED, size=SIZE)
    image = Image.new("RGB", (2 * SIZE + GAP, SIZE), (255, 255, 255))
    image.paste(moments[-3].with_arm, (0, 0))
    image.paste(moments[-1].task, (SIZE + GAP, 0))
    PICTURES.mkdir(parents=True, exist_ok=True)
    image.save(PICTURES / f"{name}.jpg", quality=80, optimize=True)
    return demo.instructions[0]


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
