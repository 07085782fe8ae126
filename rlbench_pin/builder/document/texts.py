"""The two texts of a task: replacements, and unlimited undo and redo."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass

Texts = tuple[str, str]
"""Content of the scene file and of the Python file."""
Replacement = tuple[int, int, str]
"""Start and end of the replaced part, and the new text."""


def replaced(text: str, replacements: Iterable[Replacement]) -> str:
    """Return a text after replacements that do not overlap; several replacements of the same part are joined in order."""
    joined: dict[tuple[int, int], str] = {}
    for start, end, new in replacements:
        joined[start, end] = joined.get((start, end), "") + new
    for (start, end), new in sorted(joined.items(), reverse=True):
        text = f"{text[:start]}{new}{text[end:]}"
    return text


@dataclass(frozen=True)
class Change:
    """The difference of two texts: the part at `start`, before and after the change."""

    start: int
    old: str
    new: str

    @classmethod
    def between(cls, old: str, new: str) -> Change:
        """Return the change of the shortest part outside of which two texts are equal."""
        if old == new:
            return cls(0, "", "")
        start = len(os.path.commonprefix([old, new]))
        most = min(len(old), len(new)) - start
        same = len(os.path.commonprefix([old[len(old) - most :][::-1], new[len(new) - most :][::-1]]))
        return cls(start, old[start : len(old) - same], new[start : len(new) - same])

    def applied(self, text: str) -> str:
        return f"{text[: self.start]}{self.new}{text[self.start + len(self.old) :]}"

    def reverted(self, text: str) -> str:
        return f"{text[: self.start]}{self.old}{text[self.start + len(self.new) :]}"


@dataclass(frozen=True)
class Step:
    """One edit: its name, the key under which it merges with the next one, and the changes of both texts."""

    name: str
    merge: str
    changes: tuple[Change, Change]

    def applied(self, texts: Texts) -> Texts:
        return self.changes[0].applied(texts[0]), self.changes[1].applied(texts[1])

    def reverted(self, texts: Texts) -> Texts:
        return self.changes[0].reverted(texts[0]), self.changes[1].reverted(texts[1])


class History:
    """The two texts with the steps for undo and redo; `count` increases with each edit, undo and redo."""

    def __init__(self, texts: Texts) -> None:
        self.texts = texts
        self.count = 0
        self._done: list[Step] = []
        self._undone: list[Step] = []

    @property
    def undoable(self) -> str:
        """Name of the edit that `undo` reverts; empty if there is none."""
        return self._done[-1].name if self._done else ""

    @property
    def redoable(self) -> str:
        """Name of the edit that `redo` repeats; empty if there is none."""
        return self._undone[-1].name if self._undone else ""

    def add(self, name: str, texts: Texts, merge: str = "") -> None:
        """Add an edit, unless it changes nothing.

        Args:
            name: Name of the edit on the buttons *Undo* and *Redo*.
            texts: The texts after the edit.
            merge: Key for merging: the edit is merged with the previous one if both have this key; an empty key never merges.
        """
        if texts == self.texts:
            return
        before = self.texts
        if merge and not self._undone and self._done and self._done[-1].merge == merge:
            before = self._done.pop().reverted(before)
        self._undone.clear()
        self.texts = texts
        self.count += 1
        if texts != before:
            changes = (Change.between(before[0], texts[0]), Change.between(before[1], texts[1]))
            self._done.append(Step(name, merge, changes))

    def undo(self) -> str:
        """Undo the last edit and return its name; empty if there is none."""
        if not self._done:
            return ""
        step = self._done.pop()
        self._undone.append(step)
        self.texts = step.reverted(self.texts)
        self.count += 1
        return step.name

    def redo(self) -> str:
        """Redo the last undone edit and return its name; empty if there is none."""
        if not self._undone:
            return ""
        step = self._undone.pop()
        self._done.append(step)
        self.texts = step.applied(self.texts)
        self.count += 1
        return step.name
