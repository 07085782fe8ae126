"""The two files as text, with what is wrong at its line."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Sequence
from html import escape

from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.widgets import Button, Code, Fold, Item, Markup, Note
from rlbench_pin.viewer.recording import FileKind, Problem

_AROUND = 2
_AT_COLUMN = re.compile(r"at line \d+, column (\d+)")
_WARNING = '<div style="padding:4px 8px; font-size:13px; color:#b35900">'
_NO_PROBLEM = '<div style="padding:2px 8px; font-size:13px; color:#2b9348">No problem found.</div>'
_STYLE = "font: 12px/1.45 monospace; white-space: pre; overflow-x: auto; padding: 2px 8px"


def text_items(session: Session, widen: Callable[[], None]) -> list[Item]:
    """Return both texts to edit, each below its problems.

    Args:
        session: What is being edited.
        widen: Gives the panel more room, or less again.
    """
    document = session.document
    changed = " and ".join(file.name for file in document.changed_on_disk())
    items: list[Item] = [
        Button("Wider or narrower", widen, hint="Room for long lines; the border can be dragged too"),
        Markup(f"{_WARNING}{escape(changed)} changed on disk; decide below the files.</div>" if changed else ""),
        _file(session, "scene", f"{document.name}.toml", document.scene_text),
        _file(session, "task", f"{document.name}.py", document.python_text),
    ]  # those above are always there, so that what is being typed is not made anew
    if changed:
        items.append(Note(f"{changed} changed on disk."))
        items.append(Button("Take over what is on disk", lambda: session.do(lambda d: d.reload()), "orange"))
        items.append(Button("Save over it", lambda: session.do(lambda d: d.save(over=True)), "red"))
    return items


def _file(session: Session, kind: FileKind, name: str, text: str) -> Fold:
    def commit(new: str) -> None:
        session.do(lambda document: document.set_scene_text(new) if kind == "scene" else document.set_python_text(new))

    def typing(is_typed: bool) -> None:
        session.post(lambda: session.typing(name, is_typed))

    problems = [problem for problem in problems_of(session) if problem.file == kind]
    shown = "".join(problem_html(text, problem) for problem in problems) or _NO_PROBLEM
    marked = tuple(problem.line for problem in problems if problem.line is not None)
    return Fold(name, [Markup(shown), Code(name, text, commit, typing, marked)])


def problems_of(session: Session) -> list[Problem]:
    """Return what document and stage say is wrong, each once."""
    found: Sequence[Problem] = session.document.problems
    seen = () if session.sight.opened is None else session.sight.opened.problems
    return list(dict.fromkeys([*found, *(p for p in seen if (p.file, p.line) not in {(q.file, q.line) for q in found})]))


def problem_html(text: str, problem: Problem) -> str:
    """Return a problem with its line, those around it, and a caret below where it is known."""
    where = "" if problem.line is None else f"<b>Line {problem.line}.</b> "
    message = f'<div style="color:#c0392b; padding:4px 8px; font-size:13px">{where}{escape(problem.message)}</div>'
    if problem.line is None:
        return message
    lines = text.splitlines()
    rows = []
    for number in range(max(1, problem.line - _AROUND), min(len(lines), problem.line + _AROUND) + 1):
        mark = "background:#fdecea" if number == problem.line else ""
        rows.append(f'<div style="{mark}"><span style="color:#999">{number:4d}  </span>{escape(lines[number - 1])}</div>')
        column = _column(text, problem)
        if number == problem.line and column is not None:
            rows.append(f'<div style="color:#c0392b">{" " * (column + 5)}^</div>')
    return f'{message}<div style="{_STYLE}">{"".join(rows)}</div>'


def _column(text: str, problem: Problem) -> int | None:
    """Return the column, from 1, at which reading a text ended; None when it is read, or nobody knows."""
    if problem.file == "scene":
        said = _AT_COLUMN.search(problem.message)
        return None if said is None else int(said[1])
    try:
        ast.parse(text)
    except SyntaxError as error:
        return error.offset if error.lineno == problem.line else None
    except (ValueError, RecursionError, MemoryError):
        return None
    return None
