"""Edits of the text of a scene file: keys of an entry, entries that come and go. Everything else keeps its bytes."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from rlbench_pin.builder.document.scene_text.layout import Item, Section, elements
from rlbench_pin.builder.document.scene_text.scene_text import PLACEMENT, TABLES, Entry, SceneText
from rlbench_pin.builder.document.scene_text.values import is_same, literal, place_of

Replacement = tuple[int, int, str]
"""From, to, and what stands there afterwards."""
_COMMENT = re.compile(r"([ \t]+)#")
_EXACT = 1e-12


def replaced(text: str, replacements: Iterable[Replacement]) -> str:
    """Return a text with several places of it replaced, which must not overlap."""
    for start, end, new in sorted(replacements, reverse=True):
        text = f"{text[:start]}{new}{text[end:]}"
    return text


def with_keys(scene: SceneText, entry: Entry | Section, changes: Mapping[str, Any]) -> str:
    """Return the text with keys of one entry changed.

    Args:
        scene: The file.
        entry: What to change.
        changes: Key -> plain value, or None to take the key away.
    """
    section = entry.section if isinstance(entry, Entry) else entry
    inner = entry.inner if isinstance(entry, Entry) else ()
    raw: Mapping[str, Any] = entry.raw if isinstance(entry, Entry) else scene.raw.get(section.path[0], {})
    found: list[Replacement] = []
    for key, value in sorted(changes.items(), key=lambda change: place_of(change[0])):
        tables = [part for part in inner if part.path[1] == key]
        items = [item for item in section.items if item.key == key]
        whole = len(items) == 1 and not items[0].is_dotted
        if whole and value is not None:
            found += _new_value(scene.text, items[0], raw.get(key), value)
            continue
        found += [(item.start, item.end, "") for item in items]
        found += [(_gap_before(scene.text, part.start), part.end, "") for part in tables]
        if value is not None:
            found.append(_new_line(scene.text, section, key, value))
    return replaced(scene.text, _joined(found))


def with_entry(scene: SceneText, table: str, keys: Mapping[str, Any], before: Entry | None = None) -> str:
    """Return the text with a new entry behind the last of its table, or right before another."""
    block = f"{heading_of(table)}\n{lines_of(keys)}"
    if before is not None:
        return _inserted(scene.text, before.section.start, block)
    entries = scene.of_table(table)
    if entries:
        return _inserted(scene.text, entries[-1].end, block)
    order = (PLACEMENT, *TABLES)
    later = order[order.index(table) + 1 :]
    start = next((section.start for section in scene.sections if section.path[:1] and section.path[0] in later), None)
    return _inserted(scene.text, len(scene.text) if start is None else start, block)


def without_entry(scene: SceneText, entry: Entry) -> str:
    """Return the text without an entry, its comments, and the gap behind it."""
    return replaced(scene.text, [_without_gap(scene.text, entry.section.start, entry.end)])


def with_entry_moved(scene: SceneText, entry: Entry, at: int) -> str:
    """Return the text with an entry, its comments with it, at another place: where one begins or behind the end of one."""
    start, end = entry.section.start, entry.end
    block = scene.text[start:end]
    block = block if block.endswith("\n") else f"{block}\n"
    if at > start:
        return replaced(_inserted(scene.text, at, block), [_without_gap(scene.text, start, end)])
    return _inserted(replaced(scene.text, [_without_gap(scene.text, start, end)]), at, block)


def heading_of(table: str) -> str:
    """Return `[placement]`, `[[body]]`, ..."""
    return f"[{table}]" if table == PLACEMENT else f"[[{table}]]"


def lines_of(keys: Mapping[str, Any]) -> str:
    """Return `key = value` lines, in the order in which keys are written."""
    said = sorted((item for item in keys.items() if item[1] is not None), key=lambda item: place_of(item[0]))
    return "".join(f"{key} = {literal(value, len(key) + 3)}\n" for key, value in said)


def _new_value(text: str, item: Item, old: object, new: object) -> list[Replacement]:
    """Replace what differs within a value, and keep a comment behind it in its column."""
    start, end = item.value
    found = _within(text, (start, end), old, new)
    comment = _COMMENT.match(text, end)
    if not found or comment is None or "\n" in text[start:end]:
        return found
    longer = sum(len(part) - (last - first) for first, last, part in found)
    gap = max(1, len(comment[1]) - longer)
    return [*found, (end, comment.end(1), " " * gap)] if gap != len(comment[1]) else found


def _within(text: str, span: tuple[int, int], old: object, new: object) -> list[Replacement]:
    if is_same(old, new, _EXACT):
        return []
    if isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        places = elements(text, span[0])
        return [part for place, a, b in zip(places, old, new, strict=True) for part in _within(text, place, a, b)]
    column = span[0] - text.rfind("\n", 0, span[0]) - 1
    return [(*span, literal(new, column))]


def _new_line(text: str, section: Section, key: str, value: object) -> Replacement:
    """Write a key below the last one that comes before it."""
    above = [item.end for item in section.items if place_of(item.key) <= place_of(key)]
    at = max(above, default=section.below)
    line = lines_of({key: value})
    return (at, at, line) if text[:at].endswith("\n") or not at else (at, at, f"\n{line}")


def _joined(found: Sequence[Replacement]) -> list[Replacement]:
    """Put what is written at the same place into one, in order."""
    joined: dict[tuple[int, int], str] = {}
    for start, end, new in found:
        joined[start, end] = joined.get((start, end), "") + new
    return [(start, end, new) for (start, end), new in joined.items()]


def _inserted(text: str, at: int, block: str) -> str:
    """Put a block at a place, one blank line from what is before and behind it."""
    before, behind = text[:at], text[at:]
    gap_before = "" if not before or before.endswith("\n\n") else "\n" if before.endswith("\n") else "\n\n"
    gap_behind = "" if not behind or behind.startswith("\n") else "\n"
    return f"{before}{gap_before}{block}{gap_behind}{behind}"


def _without_gap(text: str, start: int, end: int) -> Replacement:
    """Return the replacement that takes a block away, with the blank lines behind it, or before it at the end of the file."""
    while end < len(text) and text[end] in "\r\n":
        end += 1
    if end == len(text):
        start = _gap_before(text, start)
    return start, end, ""


def _gap_before(text: str, start: int) -> int:
    """Return where the blank lines above a place begin."""
    while start > 1 and text[start - 2 : start] == "\n\n":
        start -= 1
    return start
