"""Write docs/results/instructions.md: all instructions of all variations of the library, for review.

With `--check` nothing is written; it only reports whether the page is out of date.
"""

from __future__ import annotations

import inspect
import sys
from pathlib import Path
from typing import get_args

sys.path.insert(0, str(Path(__file__).parent))

from docs_lib.tasks import begin
from update_readme import checks_only, write_pages

from rlbench_pin.checking.page import markdown_table
from rlbench_pin.robot.description import DEFAULT_ROBOT, robot_description
from rlbench_pin.sim import World
from rlbench_pin.tasks import Wording, library_names, task_class, task_scene

PAGE = Path(__file__).resolve().parents[1] / "docs" / "results" / "instructions.md"
HEAD = """# Instructions

The sentences of every task, below what the task counts as success: all kinds for variation 0, then the first one of each
variation. Resets and recordings have the training sentences; the other kinds come with factors of language.
`python scripts/write_instructions.py` writes this page from the scene files.
"""


def sentences(name: str) -> list[dict[str, tuple[str, ...]]]:
    """Return the sentences of each variation of a task, by kind."""
    kind = task_class(name)
    with World(task_scene(kind), robot_description(DEFAULT_ROBOT)) as world:
        task = kind(world)
        task.init_task()
        start, found = world.save(), []
        for variation in range(task.variation_count()):
            world.restore(start)
            begin(task, variation)
            found.append({kind: task.get_wording(kind) for kind in get_args(Wording)})
    return found


def page() -> str:
    """Return the page as Markdown."""
    parts = [HEAD]
    for name in library_names():
        variations = sentences(name)
        kinds = [[kind.replace("_", "-"), "<br>".join(lines)] for kind, lines in variations[0].items()]
        parts.append(f"## {name}\n\n{inspect.getdoc(task_class(name))}\n\n{markdown_table(['Kind', 'Sentences'], kinds)}\n")
        if len(variations) > 1:
            first = [[number, said["training"][0]] for number, said in enumerate(variations)]
            parts.append(f"{markdown_table(['Variation', 'First sentence'], first)}\n")
    return "\n".join(parts)


if __name__ == "__main__":
    sys.exit(write_pages(checks_only(__doc__), {PAGE: page()}))
