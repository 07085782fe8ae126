"""Where things stand in the text of a scene file: headings, keys, values and comments, as places in the text.

The text has to be valid TOML. Nothing is turned into values here; `tomllib` does that.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

_WORD = r"""(?:[A-Za-z0-9_-]+|"(?:\\.|[^"\\\n])*"|'[^'\n]*')"""
_PATH = rf"{_WORD}(?:[ \t]*\.[ \t]*{_WORD})*"
_HEADING = re.compile(rf"(\[\[?)[ \t]*({_PATH})[ \t]*\]\]?")
_KEY = re.compile(rf"({_PATH})[ \t]*=[ \t]*")
_PART = re.compile(_WORD)
_TOKEN = re.compile(
    r'''"""(?:\\.|[^\\])*?"{3,5}|\'\'\'.*?\'{3,5}|"(?:\\.|[^"\\\n])*"|'[^'\n]*'|#[^\n]*|[\[\]{},\n]''',
    re.DOTALL,
)
"""What matters for where a value ends: texts, comments, brackets, commas, ends of lines."""


@dataclass(frozen=True)
class Item:
    """One `key = value`, on one line or on several."""

    key: str
    """As it is written, without quotes; the first part of a dotted key."""
    start: int
    """Where its first line begins."""
    value: tuple[int, int]
    """Where the value begins, and where it ends."""
    end: int
    """Behind the end of its last line."""
    is_dotted: bool = False
    """Whether it says a part of a table, such as `arc.angle`."""


@dataclass(frozen=True)
class Section:
    """A heading and what stands below it."""

    path: tuple[str, ...]
    """`("body",)` for `[[body]]`; empty before the first heading."""
    start: int
    """Where it begins: at the comment lines right above its heading, where there are any."""
    heading: int
    """Where the line of the heading begins."""
    below: int
    """Behind the line of the heading."""
    items: tuple[Item, ...]
    """What it says, in order."""
    end: int
    """Behind its last line: that of the last key, or comment lines right below it."""

    def item(self, key: str) -> Item | None:
        """Return what is said of a key, None when nothing is."""
        return next((item for item in self.items if item.key == key), None)


def layout_of(text: str) -> tuple[Section, ...]:
    """Return the sections of a valid TOML text, in order; the first has no heading."""
    sections: list[Section] = []
    path: tuple[str, ...] = ()
    heading = below = at = 0
    items: list[Item] = []
    while at < len(text):
        begin = _skip(text, at)
        found = _HEADING.match(text, begin)
        if found is not None:
            sections.append(_section(text, path, heading, below, items))
            heading, below = _line_start(text, begin), _line_end(text, found.end())
            path, items, at = _parts(found[2]), [], below
            continue
        key = _KEY.match(text, begin)
        if key is not None:
            end = value_end(text, key.end())
            at = _line_end(text, end)
            parts = _parts(key[1])
            items.append(Item(parts[0], _line_start(text, begin), (key.end(), end), at, len(parts) > 1))
            continue
        at = _line_end(text, begin)
    sections.append(_section(text, path, heading, below, items))
    return tuple(sections)


def value_end(text: str, start: int) -> int:
    """Return where the value that begins at `start` ends."""
    depth = 0
    for token in _TOKEN.finditer(text, start):
        sign = token[0]
        if sign in ("[", "{"):
            depth += 1
        elif sign in ("]", "}"):
            if depth == 0:
                return start + len(text[start : token.start()].rstrip())
            depth -= 1
        elif depth == 0 and (sign in ("\n", ",") or sign.startswith("#")):
            return start + len(text[start : token.start()].rstrip())
    return start + len(text[start:].rstrip())


def elements(text: str, start: int) -> list[tuple[int, int]]:
    """Return where the elements of the array that begins at `start` begin and end."""
    found: list[tuple[int, int]] = []
    at = start + 1
    while True:
        at = _skip(text, at)
        while at < len(text) and text[at] in "#\n,":
            at = _skip(text, _line_end(text, at) if text[at] == "#" else at + 1)
        if at >= len(text) or text[at] == "]":
            return found
        end = value_end(text, at)
        found.append((at, end))
        at = end


def line_of(text: str, place: int) -> int:
    """Return the number of the line at a place of the text, from 1."""
    return text.count("\n", 0, place) + 1


def _section(text: str, path: tuple[str, ...], heading: int, below: int, items: list[Item]) -> Section:
    start = heading
    while path and start > 0 and _is_comment(text, _line_start(text, start - 1)):
        start = _line_start(text, start - 1)
    if start > 0 and text[_line_start(text, start - 1) : start].strip():
        start = heading  # comment lines right below a key belong to what is above
    end = items[-1].end if items else below
    while end < len(text) and _is_comment(text, end):
        end = _line_end(text, end)
    return Section(path, start, heading, below, tuple(items), end)


def _is_comment(text: str, line: int) -> bool:
    return text[line : _line_end(text, line)].lstrip(" \t").startswith("#")


def _parts(path: str) -> tuple[str, ...]:
    return tuple(part.strip("\"'") for part in _PART.findall(path))


def _skip(text: str, at: int) -> int:
    while at < len(text) and text[at] in " \t\r":
        at += 1
    return at


def _line_start(text: str, at: int) -> int:
    return text.rfind("\n", 0, at) + 1


def _line_end(text: str, at: int) -> int:
    end = text.find("\n", at)
    return len(text) if end < 0 else end + 1
