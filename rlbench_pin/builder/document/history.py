"""Undo and redo without end: what each edit changed in the two texts."""

from __future__ import annotations

import os
from dataclasses import dataclass

Texts = tuple[str, str]
"""Content of the scene file and of the Python file."""


@dataclass(frozen=True)
class Change:
    """What differs between two texts: one stretch, before and after."""

    start: int
    """Where it begins."""
    old: str
    """What stood there."""
    new: str
    """What stands there."""

    @classmethod
    def between(cls, old: str, new: str) -> Change:
        """Return the shortest stretch outside of which two texts agree."""
        if old == new:
            return cls(0, "", "")
        start = len(os.path.commonprefix([old, new]))
        most = min(len(old), len(new)) - start
        same = len(os.path.commonprefix([old[len(old) - most :][::-1], new[len(new) - most :][::-1]]))
        return cls(start, old[start : len(old) - same], new[start : len(new) - same])

    def applied(self, text: str) -> str:
        """Return the text after the change."""
        return f"{text[: self.start]}{self.new}{text[self.start + len(self.old) :]}"

    def reverted(self, text: str) -> str:
        """Return the text before the change."""
        return f"{text[: self.start]}{self.old}{text[self.start + len(self.new) :]}"


@dataclass(frozen=True)
class Step:
    """One edit."""

    name: str
    """What people call it."""
    merge: str
    """Edits of the same key that follow one another are one; empty for an edit of its own."""
    changes: tuple[Change, Change]
    """Of the scene and of the Python."""

    def applied(self, texts: Texts) -> Texts:
        """Return the texts after the edit."""
        return self.changes[0].applied(texts[0]), self.changes[1].applied(texts[1])

    def reverted(self, texts: Texts) -> Texts:
        """Return the texts before the edit."""
        return self.changes[0].reverted(texts[0]), self.changes[1].reverted(texts[1])


class History:
    """The two texts and how they came to be.

    Args:
        texts: The texts at the beginning.
    """

    def __init__(self, texts: Texts) -> None:
        self.texts = texts
        self.count = 0
        """Grows with each edit, undo and redo."""
        self._done: list[Step] = []
        self._undone: list[Step] = []

    @property
    def undoable(self) -> str:
        """Name of the edit that `undo` takes back, empty when there is none."""
        return self._done[-1].name if self._done else ""

    @property
    def redoable(self) -> str:
        """Name of the edit that `redo` makes again, empty when there is none."""
        return self._undone[-1].name if self._undone else ""

    def add(self, name: str, texts: Texts, merge: str = "") -> None:
        """Make an edit; one that changes nothing is none.

        Args:
            name: What people call it.
            texts: The texts after it.
            merge: An edit of the same key right before becomes one with it.
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
        """Take the last edit back, and return its name; empty when there is none."""
        if not self._done:
            return ""
        step = self._done.pop()
        self.texts = step.reverted(self.texts)
        self._undone.append(step)
        self.count += 1
        return step.name

    def redo(self) -> str:
        """Make the edit again that was taken back last, and return its name; empty when there is none."""
        if not self._undone:
            return ""
        step = self._undone.pop()
        self.texts = step.applied(self.texts)
        self._done.append(step)
        self.count += 1
        return step.name
