"""The two files as text, with what is wrong at its line."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from rlbench_pin.builder.contracts import FileKind, Problem
from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.widgets import Button, Entry, Fold, Item, Markup, Note

_AROUND = 2
_STYLE = "font: 12px/1.45 monospace; white-space: pre; overflow-x: auto; padding: 2px 8px"


def text_items(session: Session) -> list[Item]:
    """Return both texts to edit, each below its problems."""
    document = session.document
    items: list[Item] = []
    if changed := document.changed_on_disk():
        names = ", ".join(f"`{file.name}`" for file in changed)
        items.append(Note(f"{names} changed on disk."))
        items.append(Button("Take over what is on disk", lambda: session.do(lambda d: d.reload()), "orange"))
        items.append(Button("Save over it", lambda: session.do(lambda d: d.save(over=True)), "red"))
    items.append(_file(session, "scene", f"{document.name}.toml", document.scene_text))
    items.append(_file(session, "task", f"{document.name}.py", document.python_text))
    return items


def _file(session: Session, kind: FileKind, name: str, text: str) -> Fold:
    def commit(new: str) -> None:
        if new == text:
            return
        session.do(lambda document: document.set_scene_text(new) if kind == "scene" else document.set_python_text(new))

    problems = [problem for problem in problems_of(session) if problem.file == kind]
    shown: list[Item] = [Markup(problem_html(text, problem)) for problem in problems]
    return Fold(name, [*shown, Entry(name, text, commit, f"Apply {name}", lines=True)])


def problems_of(session: Session) -> list[Problem]:
    """Return what document and stage say is wrong, each once."""
    found: Sequence[Problem] = session.document.problems
    seen = () if session.sight.opened is None else session.sight.opened.problems
    return list(dict.fromkeys([*found, *(p for p in seen if (p.file, p.line) not in {(q.file, q.line) for q in found})]))


def problem_html(text: str, problem: Problem) -> str:
    """Return a problem with the lines around it, the line itself marked."""
    message = f'<div style="color:#c0392b; padding:4px 8px; font-size:13px">{escape(problem.message)}</div>'
    if problem.line is None:
        return message
    lines = text.splitlines()
    rows = []
    for number in range(max(1, problem.line - _AROUND), min(len(lines), problem.line + _AROUND) + 1):
        mark = "background:#fdecea" if number == problem.line else ""
        rows.append(f'<div style="{mark}"><span style="color:#999">{number:4d}  </span>{escape(lines[number - 1])}</div>')
    return f'{message}<div style="{_STYLE}">{"".join(rows)}</div>'
