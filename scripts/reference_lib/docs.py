"""Documentation in the code: docstrings, the strings below attributes, defaults."""

from __future__ import annotations

import ast
import inspect
import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Any

_SECTION = re.compile(r"^(Args|Attributes|Returns|Raises|Yields):$", re.MULTILINE)
_ENTRY = re.compile(r"^(\w+): ")


@dataclass(frozen=True)
class Doc:
    """A docstring, taken apart."""

    text: str
    """Text before the first section, one paragraph per line."""
    sections: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    """`Args`, `Attributes` -> name -> what it means."""

    @property
    def first(self) -> str:
        """The first paragraph."""
        return self.text.split("\n\n")[0]


def doc_of(item: object) -> Doc:
    """Take the docstring of a class or a function apart; those of overridden methods and bases do not count."""
    parts = _SECTION.split(inspect.cleandoc(item.__doc__ or ""))
    sections = {name: _entries(body) for name, body in zip(parts[1::2], parts[2::2], strict=True)}
    paragraphs = [p if p.startswith("*") else " ".join(p.split()) for p in parts[0].strip().split("\n\n")]
    return Doc("\n\n".join(paragraphs), sections)


def _entries(body: str) -> dict[str, str]:
    """Return name -> text of the entries of one section; a text goes on in lines that are farther in."""
    entries: dict[str, str] = {}
    name = ""
    for line in textwrap.dedent(body.strip("\n")).splitlines():
        found = None if line.startswith(" ") else _ENTRY.match(line)
        if found:
            name, line = found[1], line[found.end() :]
            entries[name] = ""
        if name:
            entries[name] = f"{entries[name]} {line.strip()}".strip()
    return entries


def arguments_of(cls: type) -> Mapping[str, str]:
    """Return what the arguments of a class mean: its own `Args`, or those of the nearest base that has some."""
    return next((args for base in cls.__mro__ if (args := doc_of(base).sections.get("Args"))), {})


def attribute_docs(cls: type) -> dict[str, str]:
    """Return the strings that stand below the attributes of a class and its bases, by name."""
    docs: dict[str, str] = {}
    for base in reversed(cls.__mro__[:-1]):
        if not base.__module__.startswith("rlbench_pin"):
            continue
        tree = ast.parse(textwrap.dedent(inspect.getsource(base)))
        body = tree.body[0].body  # type: ignore[attr-defined]
        for before, after in zip(body, body[1:]):
            text = after.value.value if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant) else None
            if isinstance(before, ast.AnnAssign) and isinstance(before.target, ast.Name) and isinstance(text, str):
                docs[before.target.id] = " ".join(text.split())
    return docs


def signature(function: Callable[..., object]) -> str:
    """Return the arguments of a function or class as one types them, without types and `self`."""
    given = [p for p in inspect.signature(function).parameters.values() if p.name != "self"]
    return ", ".join(p.name if p.default is p.empty else f"{p.name}={shown(p.default)}" for p in given)


def shown(value: Any) -> str:
    """Return a default as one types it."""
    if isinstance(value, Enum):
        return f"{type(value).__name__}.{value.name}"
    text = value.__name__ if isinstance(value, type) else str(value) if isinstance(value, int | float | Path) else repr(value)
    return text.replace("'", '"')


def settings_table(cls: type) -> str:
    """Return the arguments of a class as a table: name, default, meaning."""
    means = arguments_of(cls)
    rows = [
        (f"`{p.name}`", "" if p.default is p.empty else f"`{shown(p.default)}`", means[p.name])
        for p in inspect.signature(cls).parameters.values()
    ]
    return table(("Setting", "Default", "Meaning"), rows) if rows else ""


def table(head: Sequence[str], rows: Sequence[Sequence[str]], align: str = "") -> str:
    """Return a table of Markdown.

    Args:
        head: Titles of the columns.
        rows: The cells, row by row.
        align: One letter per column, `r` for one that is aligned to the right; all to the left when empty.
    """
    lines = ["---:" if letter == "r" else "---" for letter in align.ljust(len(head), "l")]
    cells = [head, lines, *([cell.replace("|", "\\|") for cell in row] for row in rows)]
    return "\n".join(f"| {' | '.join(row)} |" for row in cells)
