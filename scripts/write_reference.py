"""Write the generated parts of the pages in docs/reference/, from the code that they describe.

The text around the generated parts is handwritten in the pages. With `--check` nothing is written; it only
reports which pages are out of date.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from reference_lib import action_modes, command_line, conditions, observations, scene_files
from update_readme import replace_part, write_pages

PAGES: Mapping[str, Callable[[], dict[str, str]]] = {
    "action_modes": action_modes.parts,
    "observations": observations.parts,
    "scene_files": scene_files.parts,
    "conditions": conditions.parts,
    "command_line": command_line.parts,
}
"""Page -> what makes its parts, by marker."""
FOLDER = Path(__file__).resolve().parents[1] / "docs" / "reference"


def text_of(page: str) -> str:
    """Return a page as it should be."""
    text = (FOLDER / f"{page}.md").read_text(encoding="utf-8")
    for marker, content in PAGES[page]().items():
        text = replace_part(text, marker, f"\n{content}\n")
    return text


def main() -> int:
    """Update, or check."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("pages", nargs="*", help=f"pages to write, of {', '.join(PAGES)}; all when none is named")
    parser.add_argument("--check", action="store_true", help="change nothing; exit 1 when something is out of date")
    arguments = parser.parse_args()
    return write_pages(arguments.check, {FOLDER / f"{page}.md": text_of(page) for page in arguments.pages or PAGES})


if __name__ == "__main__":
    sys.exit(main())
