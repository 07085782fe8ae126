"""What the tests of reference pages share: reading a page."""

from __future__ import annotations

import re

from write_reference import FOLDER


def page(name: str) -> str:
    """Return the text of a page."""
    return (FOLDER / f"{name}.md").read_text(encoding="utf-8")


def part(name: str, marker: str) -> str:
    """Return one generated part of a page."""
    found = re.search(rf"<!-- generated: {marker} -->(.*?)<!-- /generated: {marker} -->", page(name), re.DOTALL)
    assert found, marker
    return found[1]


def rows(text: str) -> list[list[str]]:
    """Return the cells of all tables in a text, without their heads."""
    lines = [line.strip("| ").replace("\\|", "/") for line in text.splitlines() if line.startswith("|")]
    cells = [[cell.strip().strip("`") for cell in line.split(" | ")] for line in lines]
    rules = [i for i, row in enumerate(cells) if set(row[0]) <= set("-:")]
    return [row for i, row in enumerate(cells) if i not in rules and i + 1 not in rules]
