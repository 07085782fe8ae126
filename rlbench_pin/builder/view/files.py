"""The tab *Files*: both files as text, with their problems."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable
from html import escape

from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.widgets import Panel
from rlbench_pin.viewer.recording import FileKind, Problem

_CONTEXT_LINES = 2
_COLUMN = re.compile(r"at line \d+, column (\d+)")
_WARNING = '<div style="padding:4px 8px; font-size:13px; color:#b35900">'
_NO_PROBLEM = '<div style="padding:2px 8px; font-size:13px; color:#2b9348">No problem found.</div>'
_STYLE = "font: 12px/1.45 monospace; white-space: pre; overflow-x: auto; padding: 2px 8px"


def show_files(panel: Panel, session: Session, widen: Callable[[], None]) -> None:
    """Show both texts to edit, each below its problems.

    Args:
        panel: The tab.
        session: The edited task.
        widen: Makes the panel wider, or narrower again.
    """
    document = session.document
    changed = " and ".join(file.name for file in document.changed_on_disk())
    panel.button("Wider or narrower", widen, hint="Room for long lines; the border can be dragged too")
    # The texts keep their positions, so that typed text stays: the line above them is always there.
    panel.html(f"{_WARNING}{escape(changed)} changed on disk; decide below the files.</div>" if changed else "")
    _show_file(panel, session, "scene", f"{document.name}.toml", document.scene_text)
    _show_file(panel, session, "task", f"{document.name}.py", document.python_text)
    if changed:
        panel.note(f"{changed} changed on disk.")
        panel.button("Load the files from disk", lambda: session.do(lambda d: d.reload()), "orange")
        panel.button("Save over it", lambda: session.do(lambda d: d.save(over=True)), "red")


def _show_file(panel: Panel, session: Session, kind: FileKind, name: str, text: str) -> None:
    def commit(new: str) -> None:
        session.do(lambda document: document.set_scene_text(new) if kind == "scene" else document.set_python_text(new))

    def typing(is_typed: bool) -> None:
        session.post(lambda: session.set_typing(name, is_typed))

    problems = [problem for problem in all_problems(session) if problem.file == kind]
    marked = tuple(problem.line for problem in problems if problem.line is not None)
    with panel.folder(name) as folder:
        folder.html("".join(problem_html(text, problem) for problem in problems) or _NO_PROBLEM)
        folder.code(name, text, commit, typing, marked)


def all_problems(session: Session) -> list[Problem]:
    """Return the problems that the document and the worker process have found, each once."""
    found = session.document.problems
    lines = {(problem.file, problem.line) for problem in found}
    others = () if session.status.opened is None else session.status.opened.problems
    return list(dict.fromkeys([*found, *(p for p in others if (p.file, p.line) not in lines)]))


def problem_html(text: str, problem: Problem) -> str:
    """Return a problem with its line, the lines around it, and a caret below its column if that is known."""
    where = "" if problem.line is None else f"<b>Line {problem.line}.</b> "
    message = f'<div style="color:#c0392b; padding:4px 8px; font-size:13px">{where}{escape(problem.message)}</div>'
    if problem.line is None:
        return message
    lines, column = text.splitlines(), _column(text, problem)
    rows = []
    for number in range(max(1, problem.line - _CONTEXT_LINES), min(len(lines), problem.line + _CONTEXT_LINES) + 1):
        mark = "background:#fdecea" if number == problem.line else ""
        rows.append(f'<div style="{mark}"><span style="color:#999">{number:4d}  </span>{escape(lines[number - 1])}</div>')
        if number == problem.line and column is not None:
            rows.append(f'<div style="color:#c0392b">{" " * (column + 5)}^</div>')
    return f'{message}<div style="{_STYLE}">{"".join(rows)}</div>'


def _column(text: str, problem: Problem) -> int | None:
    """Return the column, from 1, of a syntax error; None for other problems."""
    if problem.file == "scene":
        found = _COLUMN.search(problem.message)
        return None if found is None else int(found[1])
    try:
        ast.parse(text)
    except SyntaxError as error:
        return error.offset if error.lineno == problem.line else None
    except (ValueError, RecursionError, MemoryError):
        return None
    return None
