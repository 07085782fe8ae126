"""Text for language models: the Markdown of each page next to its HTML, and `llms.txt`, which lists them (llmstxt.org)."""

from __future__ import annotations

import fnmatch
import re
import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path

_TOCTREE = re.compile(r":::\{toctree\}\n(.*?):::\n?", re.DOTALL)
_FRONT_MATTER = re.compile(r"\A---\n.*?\n---\n\n?", re.DOTALL)
HEAD = """# rlbench-pin

> A benchmark and learning environment for robot manipulation: tasks with planned demonstrations, on Pinocchio and PyBullet.

Every page of the site is also Markdown, at the same address with `.md` in place of `.html`.
"""


def write_markdown(pages: Mapping[str, str], rendered: Path, site: Path) -> None:
    """Write the Markdown of all pages and `llms.txt` into the site.

    Args:
        pages: File -> text of the sources; those in reStructuredText are taken from `rendered`.
        rendered: Folder of the Markdown that Sphinx wrote.
        site: Folder of the site.
    """
    for name, text in pages.items():
        file = (site / name).with_suffix(".md")
        file.parent.mkdir(parents=True, exist_ok=True)
        if name.endswith(".md"):
            text = _TOCTREE.sub("", _FRONT_MATTER.sub("", text)).rstrip()
            file.write_text(f"{text}\n", encoding="utf-8")
        else:
            shutil.copy2((rendered / name).with_suffix(".md"), file)
    (site / "llms.txt").write_text(HEAD + "".join(sections(pages, site)), encoding="utf-8")


def sections(pages: Mapping[str, str], site: Path) -> Iterator[str]:
    """Yield the sections of `llms.txt`: those of the index of the site, then the pages that lists of pages lead to."""
    known = sorted(name.rsplit(".", 1)[0] for name in pages)
    left = [name for name in known if name != "index"]
    for block in _TOCTREE.findall(pages["index.md"]):
        caption = re.search(r":caption: (.*)", block)
        entries = [line for line in block.splitlines() if line and not line.startswith(":")]
        names = [name for entry in entries for name in fnmatch.filter(known, entry) if name in left]
        left = [name for name in left if name not in names]
        yield f"\n## {caption[1] if caption else 'Pages'}\n\n" + "".join(lines(names, site))
    yield "\n## Further pages\n\n" + "".join(lines(left, site))


def lines(names: list[str], site: Path) -> Iterator[str]:
    """Yield one line for each page: its title and its address."""
    for name in names:
        found = re.search(r"^# (.*)$", (site / f"{name}.md").read_text(encoding="utf-8"), re.MULTILINE)
        yield f"- [{found[1] if found else name}]({name}.md)\n"
