"""Handwritten pages, copied to the sources of the site, with adapted links."""

from __future__ import annotations

import fnmatch
import os
import re
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path

from docs_lib.public import ROOT

DOCS = ROOT / "docs"
ELSEWHERE = {
    "README.md": "readme.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changelog.md",
    "rlbench_pin/assets/LICENSES.md": "licenses_of_assets.md",
    "rlbench_pin/assets/CATALOGUE.md": "catalogue_of_assets.md",
}
"""Page outside of `docs/` -> its name on the site."""
_LINK = re.compile(r"(?<!`)(!?\[(?:[^\[\]]|\[[^\]]*\]\([^)]*\))*\])\(([^)\s#]*)(#[^)\s]*)?\)")
_FENCE = re.compile(r"(^```.*?^```$)", re.DOTALL | re.MULTILINE)
_FOR_TESTS = re.compile(r"^# not run by tests:.*\n", re.MULTILINE)
"""A line of code that only tests need."""


def copied_pages(source: Path) -> dict[str, str]:
    """Return file -> text of all pages."""
    pages = {page.relative_to(DOCS).as_posix(): page for page in sorted(DOCS.rglob("*.md"))}
    pages |= {name: ROOT / page for page, name in ELSEWHERE.items()}
    texts = {name: copied(page, source / name, source) for name, page in pages.items()}
    return {**texts, "index.md": without_empty(texts["index.md"], pages)}


def without_empty(text: str, pages: Collection[str]) -> str:
    """Drop the lines of a table of contents whose pattern fits no page: Sphinx would warn."""
    lines = text.splitlines(keepends=True)
    return "".join(line for line in lines if not re.fullmatch(r"[\w/]+\*\n", line) or fnmatch.filter(pages, f"{line.strip()}.md"))


def copied(page: Path, target: Path, source: Path) -> str:
    """Return the text of a page for its place among the sources; pages of results are left out of the search."""
    parts = _FENCE.split(page.read_text(encoding="utf-8"))
    text = "".join(
        _FOR_TESTS.sub("", part) if part.startswith("```") else with_links(part, page, target, source) for part in parts
    )
    if page.parent != DOCS / "results":
        return text
    heading = "" if text.startswith("# ") else f"# {page.stem.replace('_', ' ').capitalize()}\n\n"
    return f"---\nno-search: true\n---\n{heading}{text}"


def with_links(text: str, page: Path, target: Path, source: Path) -> str:
    """Turn relative links so that they lead from the copy of a page to the copies of pages, or to files of the repository."""

    def turned(found: re.Match[str]) -> str:
        label, path, heading = found[1], found[2], found[3] or ""
        if label.startswith("[!["):
            label = with_links(label[1:-1], page, target, source).join("[]")
        if not path or "://" in path or path.startswith("mailto:"):
            return f"{label}({path}{heading})"
        file = (page.parent / path).resolve()
        if file.is_dir():
            return label[1:-1]
        return f"{label}({os.path.relpath(place_of(file, source), target.parent)}{heading})"

    return _LINK.sub(turned, text)


def place_of(file: Path, source: Path) -> Path:
    """Return the copy of a page; other files stay where they are."""
    name = file.relative_to(ROOT).as_posix()
    if name in ELSEWHERE:
        return source / ELSEWHERE[name]
    return source / file.relative_to(DOCS) if file.is_relative_to(DOCS) and file.suffix == ".md" else file


def write(folder: Path, pages: Mapping[str, str]) -> None:
    """Write pages below a folder, leave those that have not changed as they are, and delete all others."""
    for name, text in pages.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        if not file.is_file() or file.read_text(encoding="utf-8") != text:
            file.write_text(text, encoding="utf-8")
    for file in _pages(folder):
        if file.relative_to(folder).as_posix() not in pages:
            file.unlink()


def _pages(folder: Path) -> Iterable[Path]:
    return [file for file in folder.rglob("*") if file.suffix in (".md", ".rst")]
