"""Write docs/results/instructions.md: every sentence of every variation of the library, for review.

With `--check` nothing is written; it only says whether the page is out of date.
"""

from __future__ import annotations

import inspect
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

from update_readme import update_page

from rlbench_pin.checking.page import markdown_table
from rlbench_pin.errors import BoundaryError
from rlbench_pin.robot.description import DEFAULT_ROBOT, robot_description
from rlbench_pin.sim import World
from rlbench_pin.tasks import Task, library_names, task_class, task_scene

PAGE = Path(__file__).resolve().parents[1] / "docs" / "results" / "instructions.md"
HEAD = """# Instructions

Every sentence that an episode may return, by task and variation, below what the task counts as success.
`python scripts/write_instructions.py` writes this page from the tasks.
"""
DRAWS = 20
"""Draws of an episode until its objects find a place."""


def sentences(name: str) -> list[list[str]]:
    """Return the sentences of each variation of a task."""
    kind = task_class(name)
    with World(task_scene(kind), robot_description(DEFAULT_ROBOT)) as world:
        task = kind(world)
        task.init_task()
        start, found = world.save(), []
        for variation in range(task.variation_count()):
            world.restore(start)
            found.append(_episode(task, variation))
    return found


def _episode(task: Task, variation: int) -> list[str]:
    for seed in range(DRAWS):
        try:
            return list(task.begin_episode(variation, np.random.default_rng(seed)))
        except BoundaryError:
            continue
    raise SystemExit(f"{task.get_name()}, variation {variation}: {DRAWS} draws in a row found no place.")


def page() -> str:
    """Return the page as Markdown."""
    parts = [HEAD]
    for name in library_names():
        rows = [[variation, "<br>".join(lines)] for variation, lines in enumerate(sentences(name))]
        counts = inspect.getdoc(task_class(name))
        parts.append(f"## {name}\n\n{counts}\n\n{markdown_table(['Variation', 'Sentences'], rows)}\n")
    return "\n".join(parts)


def written_anew() -> tuple[str, str]:
    """Return the page as it is, and as it should be."""
    return PAGE.read_text(encoding="utf-8") if PAGE.is_file() else "", page()


if __name__ == "__main__":
    sys.exit(update_page(__doc__, PAGE, written_anew))
