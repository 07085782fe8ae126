"""Write the table of docs/factors.md from the catalogue, and with `--images` also docs/images/factors.jpg.

With `--check` nothing is written; it only reports whether the table is out of date.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

sys.path.insert(0, str(Path(__file__).parent))

from reference_lib.docs import table
from update_readme import replace_part, write_pages

from rlbench_pin.cli.main import main as command
from rlbench_pin.environment.factors import Factor, factor_catalogue
from rlbench_pin.robot.description import DEFAULT_ROBOT, robot_description
from rlbench_pin.sim import World
from rlbench_pin.tasks import library_names, task_class, task_scene

ROOT = Path(__file__).resolve().parents[1]
PAGE, SHEET = ROOT / "docs" / "factors.md", ROOT / "docs" / "images" / "factors.jpg"
HEAD = ("Factor", "What it changes", "Level 1", "Level 2", "Level 3", "`colosseum`", "Tasks")
TASK, SIZE, LABEL = "put_rubbish_in_bin", 160, 16


def tasks_with(factors: dict[str, Factor]) -> dict[str, int]:
    """Return how many tasks of the library each factor can change."""
    counts = dict.fromkeys(factors, 0)
    for name in library_names():
        kind = task_class(name)
        with World(task_scene(kind), robot_description(DEFAULT_ROBOT)) as world:
            task = kind(world)
            task.init_task()
            for factor in factors.values():
                counts[factor.name] += not factor.why_not(task)
    return counts


def rows() -> list[tuple[str, ...]]:
    """Return a row for each factor."""
    factors = dict(factor_catalogue())
    counts = tasks_with(factors)
    return [(f"`{f.name}`", f.changes, *_levels(f), str(counts[f.name])) for f in factors.values()]


def _levels(factor: Factor) -> tuple[str, ...]:
    numbers = [*factor.levels, *[None] * (3 - len(factor.levels)), factor.colosseum]
    shown = ["" if level is None else ", ".join(map(_shown, level.values())) or "on" for level in numbers]
    return (*shown[:-1], f"{shown[-1]}, by task" if factor.by_task else shown[-1])


def _shown(value: float | tuple[float, float]) -> str:
    return f"{value[0]:g} to {value[1]:g}" if isinstance(value, tuple) else f"{value:g}"


def draw_sheet() -> None:
    """Draw the levels of every factor that can be seen, two factors in a row."""
    with tempfile.TemporaryDirectory() as folder:
        size = ("--image-size", str(SIZE), str(SIZE))
        if command(["factors", TASK, "--images", folder, *size]):
            raise SystemExit("The images could not be drawn.")
        seen = {name: Path(folder, f"{name}.png") for name in factor_catalogue() if Path(folder, f"{name}.png").exists()}
        cells = [_labelled(name, np.asarray(Image.open(path))) for name, path in seen.items()]
    cells += [np.full_like(cells[0], 255)] * (len(cells) % 2)
    pairs = [np.concatenate([a, b], axis=1) for a, b in zip(cells[::2], cells[1::2], strict=True)]
    Image.fromarray(np.concatenate(pairs)).save(SHEET, quality=85)


def _labelled(name: str, image: np.ndarray) -> np.ndarray:
    """Return an image of four levels with the name above it, padded to the right."""
    cell = Image.new("RGB", (4 * SIZE + 8, SIZE + LABEL), "white")
    cell.paste(Image.fromarray(image), (0, LABEL))
    ImageDraw.Draw(cell).text((4, 2), name, fill="black")
    return np.asarray(cell)


def main() -> int:
    """Write, or check."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="change nothing; exit 1 when the table is out of date")
    parser.add_argument("--images", action="store_true", help="draw docs/images/factors.jpg as well")
    arguments = parser.parse_args()
    text = replace_part(PAGE.read_text(encoding="utf-8"), "factors", f"\n{table(HEAD, rows(), 'llllllr')}\n")
    if arguments.images and not arguments.check:
        draw_sheet()
    return write_pages(arguments.check, {PAGE: text})


if __name__ == "__main__":
    sys.exit(main())
