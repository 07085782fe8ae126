"""The text of a scene file with what it says: its tables, and where each thing stands."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from rlbench_pin.builder.document.errors import EditRefused
from rlbench_pin.builder.document.scene_text.layout import Section, layout_of
from rlbench_pin.errors import UnknownName
from rlbench_pin.scene.reader import raw_scene
from rlbench_pin.scene.short_forms import ShortFormError, write_out

TABLES = ("body", "joint", "frame", "region", "sensor", "waypoint", "deviation", "departure")
NOTES = ("deviation", "departure")
"""The table of deviations, and its name in older files."""
"""Arrays of tables, in the order in which a new file has them."""
POSED = ("body", "frame", "region", "sensor", "waypoint")
"""Those whose things have names that are unique in a file."""
PLACEMENT = "placement"
Raw = dict[str, Any]


@dataclass(frozen=True)
class Entry:
    """What is said of a thing, or of several at once."""

    table: str
    """`body`, `joint`, ..."""
    section: Section
    """Its heading and keys."""
    end: int
    """Behind its last line, also of tables within it, such as `[joint.spring]`."""
    raw: Mapping[str, Any]
    """Its keys as they stand in the file."""
    inner: tuple[Section, ...] = ()
    """Tables within it."""
    names: tuple[str, ...] = ()
    """Names of the things that it stands for: one, or one for each of `poses`."""

    @property
    def is_several(self) -> bool:
        """Whether it stands for an array."""
        return "poses" in self.raw


@dataclass(frozen=True)
class Thing:
    """A thing of the scene and what it hangs on."""

    table: str
    """`body`, `joint`, ..."""
    name: str
    """Its name; of a joint `<body>/<joint>`."""
    parent: str
    """As it is written, `root` when it is not; the body of a joint."""


class SceneText:
    """A scene file as text.

    Args:
        text: Its content.
        path: Where it lies.

    Raises:
        SceneFileError: It is not valid TOML.
    """

    def __init__(self, text: str, path: Path) -> None:
        self.text, self.path = text, path
        self.raw: Raw = raw_scene(text, path)

    @cached_property
    def sections(self) -> tuple[Section, ...]:
        """Where everything stands."""
        return layout_of(self.text)

    @property
    def has_short_forms(self) -> bool:
        """Whether the format has `rpy` and `poses`."""
        return self.raw.get("format") != 1

    @cached_property
    def entries(self) -> tuple[Entry, ...]:
        """What is said under `[[table]]`, in the order of the file."""
        counts, found = dict.fromkeys(TABLES, 0), []
        for number, section in enumerate(self.sections):
            if len(section.path) != 1 or section.path[0] not in TABLES:
                continue
            table = section.path[0]
            content = self.raw.get(table)
            if not isinstance(content, list) or not all(isinstance(entry, dict) for entry in content):
                continue
            raw = content[counts[table]]
            counts[table] += 1
            inner = tuple(_inner(self.sections[number + 1 :], table))
            end = inner[-1].end if inner else section.end
            found.append(Entry(table, section, end, raw, inner, _names(table, raw)))
        return tuple(found)

    def of_table(self, table: str) -> tuple[Entry, ...]:
        """Return the entries of a table."""
        return tuple(entry for entry in self.entries if entry.table == table)

    @cached_property
    def things(self) -> tuple[Thing, ...]:
        """Everything that has a name, in the order of the file."""
        return tuple(
            Thing(entry.table, name, name.partition("/")[0] if entry.table == "joint" else str(entry.raw.get("parent", "root")))
            for entry in self.entries
            if entry.table not in NOTES
            for name in entry.names
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all things."""
        return tuple(thing.name for thing in self.things)

    def find(self, name: str) -> Entry:
        """Return what is said of a thing.

        Raises:
            UnknownName: There is none of that name.
        """
        for entry in self.entries:
            if name in entry.names and entry.table not in NOTES:
                return entry
        raise UnknownName("thing of the scene", name, self.names)

    def section(self, table: str) -> Section | None:
        """Return the section of a table that there is once, such as `placement`; None when it is not there."""
        return next((section for section in self.sections if section.path == (table,)), None)

    def refuse_inline(self, edit: str, table: str) -> None:
        """Raise EditRefused when a table is written in one line, where entries have no place of their own."""
        content = self.raw.get(table)
        if content is not None and not any(section.path[:1] == (table,) for section in self.sections):
            words = f"[{table}]" if isinstance(content, dict) else f"[[{table}]]"
            raise EditRefused(edit, f"'{table}' is not written under the heading {words}.", f"Write {words} in the text.")


def _inner(behind: tuple[Section, ...], table: str) -> Iterator[Section]:
    for section in behind:
        if section.path[0] != table or len(section.path) == 1:
            return
        yield section


def _names(table: str, raw: Mapping[str, Any]) -> tuple[str, ...]:
    try:
        return tuple(str(item.get("name", "")) for item in write_out(table, dict(raw)))
    except ShortFormError:
        return (str(raw.get("name", "")),)
