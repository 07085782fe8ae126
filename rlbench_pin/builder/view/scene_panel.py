"""Undo, redo and save above the tabs; in the tab *Scene* problems, drafts, and the tree of all elements."""

from __future__ import annotations

import difflib
from collections.abc import Iterator
from pathlib import Path

from rlbench_pin.builder.document import Draft, DraftKeeper
from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.waypoints import VERDICT_COLORS
from rlbench_pin.builder.view.widgets import Color, Panel
from rlbench_pin.scene import SceneSpec
from rlbench_pin.scene.spec import ROOT, WORLD, PosedSpec

_MARKS = {"BodySpec": "■", "FrameSpec": "✛", "RegionSpec": "▭", "SensorSpec": "◎", "WaypointSpec": "◆"}

_LEFT_ALIGNED = (
    '<div class="element-tree"></div>'
    "<style>div:has(> .element-tree) ~ div > button .mantine-Button-inner { justify-content: flex-start }</style>"
)
"""Viser centres the labels of buttons, so that an indentation would move them by half of it."""


class Drafts:
    """Keeps unsaved edits as a draft, and offers the draft of an earlier session.

    Args:
        session: The edited task.
    """

    def __init__(self, session: Session) -> None:
        self._session, self._shown_news = session, ""
        self._keeper = DraftKeeper(session.document, lambda: session.post(self._show_news, "draft"))
        session.listen(self._keeper.keep)

    @property
    def file(self) -> Path | None:
        """The draft of the unsaved edits; None if there is none."""
        return self._keeper.file if self._keeper.file.is_file() else None

    def show(self, panel: Panel) -> None:
        """Show the offered draft, if there is one."""
        if self._keeper.news:
            panel.note(f"⚠ {self._keeper.news}")
        if self._keeper.offered:
            panel.note(self._description(self._keeper.offered[0]))
            panel.button("Apply the draft", self._take, "orange", "One edit, which can be undone")
            panel.button("Discard the draft", self._drop)

    def close(self) -> None:
        """Write the unsaved edits to the draft."""
        self._keeper.close()

    def _description(self, draft: Draft) -> str:
        document = self._session.document
        names = (f"{document.name}.toml", f"{document.name}.py")
        counts = [_changed_lines(*pair) for pair in zip(document.texts, draft.texts, strict=True)]
        lines = " and ".join(f"{count} lines of `{name}`" for count, name in zip(counts, names, strict=True) if count)
        text = f"**A draft of {draft.written}** was not saved. It differs from the task in {lines or 'no line'}."
        return text if self._keeper.is_of_now(draft) else f"{text} **The files have been changed since then.**"

    def _show_news(self) -> None:
        if self._keeper.news != self._shown_news:
            self._shown_news = self._keeper.news
            self._session.changed()

    def _take(self) -> None:
        self._session.do(lambda document: self._keeper.take())

    def _drop(self) -> None:
        self._keeper.drop()
        self._session.changed()


def _changed_lines(old: str, new: str) -> int:
    """Return the number of changed lines, roughly for long texts."""
    first, second = old.splitlines(), new.splitlines()
    if max(len(first), len(second)) > 5000:
        return len(set(first) ^ set(second)) or int(first != second)
    blocks = difflib.SequenceMatcher(None, first, second, autojunk=True).get_opcodes()
    return sum(max(b - a, d - c) for word, a, b, c, d in blocks if word != "equal") or int(old != new)


def show_edits(panel: Panel, session: Session) -> None:
    """Show undo, redo and save."""
    document = session.document
    undo, redo = document.undoable, document.redoable
    panel.note(f"**{document.name}**{' ·  not saved' if document.unsaved else ''}")
    panel.button(f"Undo: {undo}" if undo else "Undo", lambda: session.do(lambda d: d.undo()), disabled=not undo, key="undo")
    panel.button(f"Redo: {redo}" if redo else "Redo", lambda: session.do(lambda d: d.redo()), disabled=not redo, key="redo")
    panel.button("Save", session.save, "blue" if document.unsaved else "gray", key="save")


def show_header(panel: Panel, session: Session) -> None:
    """Show typed text that is not applied, and problems."""
    document = session.document
    if session.typed:
        panel.note(f"Typed in {' and '.join(sorted(session.typed))}, not applied: see *Files*.")
    if problems := document.problems:
        lines = [
            f"- `{document.name}.{'toml' if p.file == 'scene' else 'py'}` line {p.line or '-'}: {p.message}" for p in problems
        ]
        with panel.folder(f"Problems ({len(problems)})") as folder:
            folder.note("\n".join(lines))


def show_tree(panel: Panel, session: Session) -> None:
    """Show a button for each element, indented below its parent."""

    def show(name: str, label: str, depth: int) -> None:
        verdict = session.status.verdicts.get(name)
        color: Color = "gray" if verdict is None else VERDICT_COLORS[verdict.standing]
        if name == session.selected:
            color = "blue"
        hint = "" if verdict is None else verdict.cause
        panel.button("\u2003" * depth + label, lambda: session.select(name), color, hint, key=f"{depth} {name}")

    panel.html(_LEFT_ALIGNED)
    show(ROOT, "⌂ root", 0)
    for element, depth in branches(session.spec):
        show(element.name, f"{_MARKS[type(element).__name__]} {element.name}", depth)
    if not session.spec.posed():
        panel.note("The scene is empty: see *Add*.")


def branches(spec: SceneSpec) -> Iterator[tuple[PosedSpec, int]]:
    """Yield all elements after their parents, with their depth; elements in a cycle of parents come last."""
    children: dict[str, list[PosedSpec]] = {}
    for element in spec.posed():
        children.setdefault(element.parent.partition("/")[0], []).append(element)
    seen: set[str] = set()

    def below(parent: str, depth: int) -> Iterator[tuple[PosedSpec, int]]:
        for element in children.get(parent, ()):
            if element.name not in seen:
                seen.add(element.name)
                yield element, depth
                yield from below(element.name, depth + 1)

    yield from below(ROOT, 1)
    yield from below(WORLD, 0)
    yield from ((element, 0) for element in spec.posed() if element.name not in seen)
