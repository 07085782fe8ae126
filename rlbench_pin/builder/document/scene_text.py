"""Scene files as text: the positions of headings, keys and values, and edits that leave the rest of the text byte-identical.

`tomllib` reads the values. A scanner in this module finds the positions, because an edit moves the comments above a heading with
its entry and keeps the columns of comments, and because `tomlkit` takes 6 to 33 ms to parse a scene of the library.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path, PurePosixPath
from typing import Any

from rlbench_pin.builder.document.errors import EditRefused
from rlbench_pin.builder.document.scene_values import is_same, literal, place_of, pose_keys, short_pose
from rlbench_pin.builder.document.texts import Replacement, replaced
from rlbench_pin.errors import UnknownName
from rlbench_pin.scene.reader import RESERVED, ShortFormError, raw_scene, write_out
from rlbench_pin.scene.writer import TABLES

PLACEMENT = "placement"
_WORD = r"""(?:[A-Za-z0-9_-]+|"(?:\\.|[^"\\\n])*"|'[^'\n]*')"""
_PATH = rf"{_WORD}(?:[ \t]*\.[ \t]*{_WORD})*"
_HEADING = re.compile(rf"(\[\[?)[ \t]*({_PATH})[ \t]*\]\]?")
_KEY = re.compile(rf"({_PATH})[ \t]*=[ \t]*")
_PART = re.compile(_WORD)
_TOKEN = re.compile(
    r'''"""(?:\\.|[^\\])*?"{3,5}|\'\'\'.*?\'{3,5}|"(?:\\.|[^"\\\n])*"|'[^'\n]*'|#[^\n]*|[\[\]{},\n]''',
    re.DOTALL,
)
"""Tokens that decide where a value ends: strings, comments, brackets, commas, ends of lines."""
_COMMENT = re.compile(r"([ \t]+)#")
_NUMBERED = re.compile(r"(.*[^0-9])([0-9]{1,9})")
_EXACT = 1e-12


# Layout -----------------------------------------------------------------------------------------------------------------------
NOTES = ("deviation", "departure")
"""The table of deviations, and its name in older files."""


@dataclass(frozen=True)
class Item:
    """One `key = value`, on one line or on several.

    Attributes:
        key: The key without quotes; the first part of a dotted key.
        start: Start of its first line.
        value: Start and end of the value.
        end: End of its last line.
        is_dotted: Whether it is a part of a table, such as `arc.angle`.
    """

    key: str
    start: int
    value: tuple[int, int]
    end: int
    is_dotted: bool


@dataclass(frozen=True)
class Section:
    """A heading and the keys below it.

    Attributes:
        path: `("body",)` for `[[body]]`; empty before the first heading.
        start: Start of the comment lines right above the heading, or of the heading.
        heading: Start of the line of the heading.
        below: End of the line of the heading.
        items: The keys in order.
        end: End of the last line: that of the last key, or of the comment lines directly below it.
    """

    path: tuple[str, ...]
    start: int
    heading: int
    below: int
    items: tuple[Item, ...]
    end: int

    def item(self, key: str) -> Item | None:
        return next((item for item in self.items if item.key == key), None)


def layout_of(text: str) -> tuple[Section, ...]:
    """Return the sections of a valid TOML text, in order; the first has no heading."""
    sections: list[Section] = []
    path: tuple[str, ...] = ()
    heading = below = at = 0
    items: list[Item] = []
    while at < len(text):
        begin = _skip_blanks(text, at)
        if found := _HEADING.match(text, begin):
            sections.append(_section(text, path, heading, below, items))
            heading, below = _line_start(text, begin), _line_end(text, found.end())
            path, items, at = _parts(found[2]), [], below
        elif key := _KEY.match(text, begin):
            end = _value_end(text, key.end())
            at = _line_end(text, end)
            parts = _parts(key[1])
            items.append(Item(parts[0], _line_start(text, begin), (key.end(), end), at, len(parts) > 1))
        else:
            at = _line_end(text, begin)
    sections.append(_section(text, path, heading, below, items))
    return tuple(sections)


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


def _value_end(text: str, start: int) -> int:
    depth = 0
    for token in _TOKEN.finditer(text, start):
        sign = token[0]
        if sign in ("[", "{"):
            depth += 1
        elif sign in ("]", "}") and depth:
            depth -= 1
        elif depth == 0 and (sign in ("]", "}", "\n", ",") or sign.startswith("#")):
            return start + len(text[start : token.start()].rstrip())
    return start + len(text[start:].rstrip())


def _array_items(text: str, start: int) -> list[tuple[int, int]]:
    """Return the start and end of each item of the array that begins at `start`."""
    found: list[tuple[int, int]] = []
    at = start + 1
    while True:
        at = _skip_blanks(text, at)
        while at < len(text) and text[at] in "#\n,":
            at = _skip_blanks(text, _line_end(text, at) if text[at] == "#" else at + 1)
        if at >= len(text) or text[at] == "]":
            return found
        end = _value_end(text, at)
        found.append((at, end))
        at = end


def _is_comment(text: str, line: int) -> bool:
    return text[line : _line_end(text, line)].lstrip(" \t").startswith("#")


def _parts(path: str) -> tuple[str, ...]:
    return tuple(part.strip("\"'") for part in _PART.findall(path))


def _skip_blanks(text: str, at: int) -> int:
    while at < len(text) and text[at] in " \t\r":
        at += 1
    return at


def _line_start(text: str, at: int) -> int:
    return text.rfind("\n", 0, at) + 1


def _line_end(text: str, at: int) -> int:
    end = text.find("\n", at)
    return len(text) if end < 0 else end + 1


# Content ----------------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Entry:
    """A table of the file: one element of the scene, or an array of them.

    Attributes:
        table: `body`, `joint`, ..., or `placement`.
        section: Its heading and keys.
        raw: Its keys as they are in the file.
        inner: Tables within it, such as `[joint.spring]`.
        names: Name of the element, or one name for each of `poses`.
    """

    table: str
    section: Section
    raw: Mapping[str, Any]
    inner: tuple[Section, ...] = ()
    names: tuple[str, ...] = ()

    @property
    def end(self) -> int:
        """End of the last line, including inner tables."""
        return (self.inner[-1] if self.inner else self.section).end

    @property
    def is_array(self) -> bool:
        return "poses" in self.raw


@dataclass(frozen=True)
class Element:
    """A named element: its table, its name (`<body>/<joint>` of a joint), and its parent (`root` by default, a joint's body)."""

    table: str
    name: str
    parent: str


class SceneText:
    """A scene file as text, with its values in `raw`.

    Raises:
        SceneFileError: The text is not valid TOML.
    """

    def __init__(self, text: str, path: Path) -> None:
        self.text, self.path = text, path
        self.raw: dict[str, Any] = raw_scene(text, path)

    @cached_property
    def sections(self) -> tuple[Section, ...]:
        return layout_of(self.text)

    @property
    def has_short_forms(self) -> bool:
        """Whether the format has `rpy` and `poses`."""
        return self.raw.get("format") != 1

    @cached_property
    def entries(self) -> tuple[Entry, ...]:
        """The entries of all arrays of tables, in the order of the file."""
        counts, found = dict.fromkeys((*TABLES, *NOTES), 0), []
        for number, section in enumerate(self.sections):
            if len(section.path) != 1 or section.path[0] not in (*TABLES, *NOTES):
                continue
            table = section.path[0]
            content = self.raw.get(table)
            if not isinstance(content, list) or not all(isinstance(entry, dict) for entry in content):
                continue
            raw = content[counts[table]]
            counts[table] += 1
            found.append(Entry(table, section, raw, tuple(self._inner(number, table)), _names(table, raw)))
        return tuple(found)

    def _inner(self, number: int, table: str) -> Iterator[Section]:
        for section in self.sections[number + 1 :]:
            if section.path[0] != table or len(section.path) == 1:
                return
            yield section

    def of_table(self, table: str) -> tuple[Entry, ...]:
        return tuple(entry for entry in self.entries if entry.table == table)

    @cached_property
    def elements(self) -> tuple[Element, ...]:
        """All elements that have a name, in the order of the file."""
        return tuple(
            Element(entry.table, name, name.partition("/")[0] if entry.table == "joint" else str(entry.raw.get("parent", "root")))
            for entry in self.entries
            if entry.table not in NOTES
            for name in entry.names
        )

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(element.name for element in self.elements)

    def find(self, name: str) -> Entry:
        """Return the entry of an element, or raise UnknownName."""
        for entry in self.entries:
            if name in entry.names and entry.table not in NOTES:
                return entry
        raise UnknownName("element of the scene", name, self.names)

    def section(self, table: str) -> Section | None:
        """Return the section of a table that occurs once, such as `placement`."""
        return next((section for section in self.sections if section.path == (table,)), None)

    def refuse_inline(self, edit: str, table: str) -> None:
        """Raise EditRefused if a table is written in one line, which has no place for new entries or keys."""
        content = self.raw.get(table)
        if content is not None and not any(section.path[:1] == (table,) for section in self.sections):
            words = f"[{table}]" if isinstance(content, dict) else f"[[{table}]]"
            raise EditRefused(edit, f"'{table}' is not written under the heading {words}.", f"Write {words} in the text.")


def _names(table: str, raw: Mapping[str, Any]) -> tuple[str, ...]:
    try:
        return tuple(str(item.get("name", "")) for item in write_out(table, dict(raw)))
    except ShortFormError:
        return (str(raw.get("name", "")),)


# Keys and entries -------------------------------------------------------------------------------------------------------------


def with_keys(scene: SceneText, entry: Entry, changes: Mapping[str, Any]) -> str:
    """Return the text with keys of one entry changed: key -> plain value, or None to remove the key."""
    section, found = entry.section, list[Replacement]()
    for key, value in sorted(changes.items(), key=lambda change: place_of(change[0])):
        items = [item for item in section.items if item.key == key]
        if len(items) == 1 and not items[0].is_dotted and value is not None:
            found += _new_value(scene.text, items[0], entry.raw.get(key), value)
            continue
        found += [(item.start, item.end, "") for item in items]
        found += [(_gap_start(scene.text, part.start), part.end, "") for part in entry.inner if part.path[1] == key]
        if value is not None:
            above = [item.end for item in section.items if place_of(item.key) <= place_of(key)]
            at, line = max(above, default=section.below), _lines({key: value})
            found.append((at, at, line if not at or scene.text[at - 1] == "\n" else f"\n{line}"))
    return replaced(scene.text, found)


def with_entry(scene: SceneText, table: str, keys: Mapping[str, Any], before: Entry | None = None) -> str:
    """Return the text with a new entry after the last one of its table, or directly before another entry."""
    block = f"{_heading(table)}\n{_lines(keys)}"
    if before is not None:
        return _inserted(scene.text, before.section.start, block)
    if entries := scene.of_table(table):
        return _inserted(scene.text, entries[-1].end, block)
    order = (PLACEMENT, *TABLES)
    later = order[order.index(table) + 1 :]
    start = next((section.start for section in scene.sections if section.path[:1] and section.path[0] in later), None)
    return _inserted(scene.text, len(scene.text) if start is None else start, block)


def without_entry(scene: SceneText, entry: Entry) -> str:
    """Return the text without an entry, its comments and the blank lines after it."""
    return replaced(scene.text, [_removal(scene.text, entry)])


def with_entry_moved(scene: SceneText, entry: Entry, at: int) -> str:
    """Return the text with an entry and its comments moved to the position `at`, the start or end of another entry."""
    block = scene.text[entry.section.start : entry.end]
    block = block if block.endswith("\n") else f"{block}\n"
    removal = _removal(scene.text, entry)
    if at > entry.section.start:
        return replaced(_inserted(scene.text, at, block), [removal])
    return _inserted(replaced(scene.text, [removal]), at, block)


def _heading(table: str) -> str:
    return f"[{table}]" if table == PLACEMENT else f"[[{table}]]"


def _lines(keys: Mapping[str, Any]) -> str:
    """Return `key = value` lines in the order of the library."""
    written = sorted((item for item in keys.items() if item[1] is not None), key=lambda item: place_of(item[0]))
    return "".join(f"{key} = {literal(value, len(key) + 3)}\n" for key, value in written)


def _new_value(text: str, item: Item, old: object, new: object) -> list[Replacement]:
    """Return the replacements for the changed parts of a value; a comment after it stays in its column."""
    start, end = item.value
    found = _differences(text, (start, end), old, new)
    comment = _COMMENT.match(text, end)
    if not found or comment is None or "\n" in text[start:end]:
        return found
    growth = sum(len(part) - (last - first) for first, last, part in found)
    return [*found, (end, comment.end(1), " " * max(1, len(comment[1]) - growth))]


def _differences(text: str, span: tuple[int, int], old: object, new: object) -> list[Replacement]:
    if is_same(old, new, _EXACT):
        return []
    if isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        places = _array_items(text, span[0])
        return [part for place, a, b in zip(places, old, new, strict=True) for part in _differences(text, place, a, b)]
    return [(*span, literal(new, span[0] - _line_start(text, span[0])))]


def _inserted(text: str, at: int, block: str) -> str:
    """Return the text with a block inserted, with one blank line before and after it."""
    before, behind = text[:at], text[at:]
    gap_before = "" if not before or before.endswith("\n\n") else "\n" if before.endswith("\n") else "\n\n"
    gap_behind = "" if not behind or behind.startswith("\n") else "\n"
    return f"{before}{gap_before}{block}{gap_behind}{behind}"


def _removal(text: str, entry: Entry) -> Replacement:
    """Return the replacement that removes an entry with the blank lines after it, or before it at the end of the file."""
    start, end = entry.section.start, entry.end
    while end < len(text) and text[end] in "\r\n":
        end += 1
    return (_gap_start(text, start) if end == len(text) else start), end, ""


def _gap_start(text: str, start: int) -> int:
    """Return the start of the blank lines above a position."""
    while start > 1 and text[start - 2 : start] == "\n\n":
        start -= 1
    return start


# Arrays of elements -----------------------------------------------------------------------------------------------------------


def with_array_pose(scene: SceneText, entry: Entry, name: str, pose: Any) -> str | None:
    """Return the text with one of the poses of an array changed; None when the array cannot express it."""
    index = entry.names.index(name)
    poses = [*entry.raw["poses"]]
    if "rpy" in entry.raw:
        found = pose_keys(pose, {"pose": poses[index], "rpy": entry.raw["rpy"]}, has_rpy=True)
        if "rpy" in found or len(found.get("pose") or ()) not in (0, 3):
            return None
        if "pose" in found:
            poses[index] = found["pose"] or [0.0, 0.0, 0.0]
    else:
        poses[index] = short_pose(pose, poses[index])
    return with_keys(scene, entry, {"poses": poses})


def detached(scene: SceneText, name: str) -> SceneText:
    """Return the file in which an element has its own entry; an array that contains it is split."""
    entry = scene.find(name)
    if not entry.is_array:
        return scene
    index = entry.names.index(name)
    if len(entry.names) == 1:
        return SceneText(with_keys(scene, entry, {"poses": None, "pose": entry.raw["poses"][0]}), scene.path)
    single, behind = _block(entry, slice(index, index + 1)), slice(index + 1, None)
    changed = _shortened(scene, entry, slice(0, index) if index else behind)
    end = entry.end + len(changed) - len(scene.text)
    rest = changed[entry.section.start : end]
    rest = rest if rest.endswith("\n") else f"{rest}\n"
    if index == 0:
        blocks = [single, rest]
    else:
        blocks = [rest, single, *([_block(entry, behind)] if entry.names[behind] else [])]
    return SceneText(replaced(changed, [(entry.section.start, end, "\n".join(blocks))]), scene.path)


def _shortened(scene: SceneText, entry: Entry, kept: slice) -> str:
    """Return the text in which an array contains only the elements `kept`."""
    names, poses = entry.names[kept], entry.raw["poses"][kept]
    if len(names) == 1:
        return with_keys(scene, entry, {"name": names[0], "poses": None, "pose": poses[0]})
    text = with_keys(scene, entry, {"name": names[0]})
    item, called = entry.section.item("poses"), entry.section.item("name")
    assert item is not None and called is not None
    growth = len(text) - len(scene.text) if called.start < item.start else 0
    places = _array_items(text, item.value[0] + growth)
    chosen = places[kept]
    return replaced(text, [(places[0][0], chosen[0][0], ""), (chosen[-1][1], places[-1][1], "")])


def _block(entry: Entry, part: slice) -> str:
    """Return the text of a new entry for some elements of an array."""
    names, poses = entry.names[part], entry.raw["poses"][part]
    posed: Mapping[str, Any] = {"pose": poses[0], "poses": None} if len(names) == 1 else {"poses": poses}
    return f"{_heading(entry.table)}\n{_lines({**entry.raw, **posed, 'name': names[0]})}"


# Names ------------------------------------------------------------------------------------------------------------------------


def free_name(wanted: str, taken: Collection[str]) -> str:
    """Return `cup`, or `cup_2`, `cup_3`, ... where it is taken; of `cup4` the next number that is free."""
    used = {*taken, *RESERVED}
    if wanted not in used:
        return wanted
    numbered = _NUMBERED.fullmatch(wanted)
    stem, first = (numbered[1], int(numbered[2]) + 1) if numbered else (f"{wanted}_", 2)
    return next(name for k in range(first, first + len(used) + 1) if (name := f"{stem}{k}") not in used)


def name_from_asset(asset: str) -> str:
    """Return a name for a body of an asset, such as `cup` of `objects/cup/cup.urdf`."""
    words = re.sub(r"[^a-z0-9]+", "_", PurePosixPath(asset).stem.lower()).strip("_")
    return words if words[:1].isalpha() else f"body_{words}".rstrip("_")


def dependants(scene: SceneText, name: str) -> tuple[Element, ...]:
    """Return the descendants of an element with the joints of bodies, nearest first."""
    found: list[Element] = []
    owners = [name]
    while owners:
        owner = owners.pop(0)
        near = [element for element in scene.elements if element.parent.partition("/")[0] == owner and element not in found]
        found += near
        owners += [element.name for element in near if element.table != "joint"]
    return tuple(element for element in found if element.name != name)


def renamed(scene: SceneText, names: Mapping[str, str]) -> SceneText:
    """Return the file with elements renamed, all at once (old name -> new name): names, parents, joints of bodies."""
    for name in names:
        scene = detached(scene, name)
    found: list[Replacement] = []
    for entry in scene.entries:
        for key in ("name", "parent") if entry.table not in NOTES else ():
            item, old = entry.section.item(key), entry.raw.get(key)
            if item is None or not isinstance(old, str):
                continue
            owner, slash, rest = old.partition("/")
            is_own_name = key == "name" and entry.table != "joint"
            new = names.get(old, old) if is_own_name else names.get(owner, owner) + slash + rest
            if new != old:
                found.append((*item.value, literal(new)))
    return SceneText(replaced(scene.text, found), scene.path)
