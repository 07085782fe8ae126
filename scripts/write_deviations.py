"""Write docs/results/deviations.md from the `[[deviation]]` entries of the library's scenes.

With `--check` nothing is written; it only reports whether the page is out of date.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from reference_lib.docs import table
from update_readme import checks_only, write_pages

from rlbench_pin.tasks import library_names, task_class, task_scene

PAGE = Path(__file__).resolve().parents[1] / "docs" / "results" / "deviations.md"
START = """# Deviations of each task

[deviations.md](../deviations.md) explains the columns. Written by `python scripts/write_deviations.py`.

"""
HEAD = ("Task", "What", "Kind", "Specified", "Here", "Reason")


def rows() -> Iterator[tuple[str, ...]]:
    """Yield one row per deviation, and one for each task that has none."""
    for name in library_names():
        deviations = task_scene(task_class(name)).deviation
        if not deviations:
            yield (f"`{name}`", "none", "", "", "", "")
        for number, entry in enumerate(deviations):
            kind = "asked" if entry.binding else "proposed"
            yield ("" if number else f"`{name}`", entry.name, kind, entry.specified, entry.here, entry.reason)


def page() -> str:
    """Return the page as Markdown."""
    return f"{START}{table(HEAD, list(rows()))}\n"


if __name__ == "__main__":
    sys.exit(write_pages(checks_only(__doc__), {PAGE: page()}))
