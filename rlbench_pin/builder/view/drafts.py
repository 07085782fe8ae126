"""Drafts in the page: one of an earlier time is offered above the tree; what is edited is kept as one."""

from __future__ import annotations

import difflib
from pathlib import Path

from rlbench_pin.builder.document import Draft, DraftKeeper
from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.widgets import Button, Item, Note


class Drafts:
    """Offers drafts, and keeps them.

    Args:
        session: What is being edited.
    """

    def __init__(self, session: Session) -> None:
        self._session, self._said = session, ""
        self._keeper = DraftKeeper(session.document, lambda: session.post(self._heard, "draft"))
        session.listen(self._keeper.keep)

    @property
    def file(self) -> Path | None:
        """Where what is not saved is kept; None when there is no such file."""
        return self._keeper.file if self._keeper.file.is_file() else None

    def items(self) -> list[Item]:
        """Return what is offered, with two buttons; nothing when there is nothing."""
        items: list[Item] = []
        if self._keeper.news:
            items.append(Note(f"⚠ {self._keeper.news}"))
        if self._keeper.offered:
            items.append(Note(self._words(self._keeper.offered[0])))
            items.append(Button("Take up the draft", self._take, shade="orange", hint="One edit, which can be undone"))
            items.append(Button("Drop the draft", self._drop))
        return items

    def close(self) -> None:
        """Write what is not written yet."""
        self._keeper.close()

    def _words(self, draft: Draft) -> str:
        """Return what is said of a draft."""
        document = self._session.document
        names = (f"{document.name}.toml", f"{document.name}.py")
        counts = [_differing(*pair) for pair in zip(document.texts, draft.texts, strict=True)]
        lines = " and ".join(f"{count} lines of `{name}`" for count, name in zip(counts, names, strict=True) if count)
        said = f"**A draft of {draft.written}** was not saved. It differs from the task in {lines or 'nothing'}."
        return said if self._keeper.is_of_now(draft) else f"{said} **The files have been changed since then.**"

    def _heard(self) -> None:
        """Show what is new of the file."""
        if self._keeper.news != self._said:
            self._said = self._keeper.news
            self._session.changed()

    def _take(self) -> None:
        self._session.do(lambda document: self._keeper.take())

    def _drop(self) -> None:
        self._keeper.drop()
        self._session.changed()


def _differing(old: str, new: str) -> int:
    """Return how many lines of a text differ from another, roughly where they are long."""
    first, second = old.splitlines(), new.splitlines()
    if max(len(first), len(second)) > 5000:
        return len(set(first) ^ set(second)) or int(first != second)
    blocks = difflib.SequenceMatcher(None, first, second, autojunk=True).get_opcodes()
    return sum(max(b - a, d - c) for word, a, b, c, d in blocks if word != "equal") or int(old != new)
