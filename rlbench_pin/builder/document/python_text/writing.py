"""How Python is laid out: lists on one line or several, statements that come and go, docstrings."""

from __future__ import annotations

import ast
from collections.abc import Sequence

from rlbench_pin.builder.document.python_text.layout import LONGEST_LINE, listed
from rlbench_pin.builder.document.python_text.source import Function, Replacement, Source
from rlbench_pin.builder.document.python_text.task_class import body_of


def new_list(source: Source, node: ast.List | ast.Tuple, old: Sequence[str], new: Sequence[str]) -> list[Replacement]:
    """Return what to replace so that a list has other parts; those that stay in their places keep their bytes."""
    places = [source.span(part) for part in node.elts]
    if len(old) == len(new):
        changed = [(*place, b) for place, a, b in zip(places, old, new, strict=True) if a != b]
        if all(_fits(source, *replacement) for replacement in changed):
            return changed
    start, end = source.span(node)
    line, stop = _line(source, start, end)
    before = source.text[line:start]
    indent = before[: len(before) - len(before.lstrip())]
    brackets = "()" if isinstance(node, ast.Tuple) else "[]"
    return [(start, end, listed(new, indent, len(before), stop - end, brackets))]


def _fits(source: Source, start: int, end: int, new: str) -> bool:
    """Whether a line is short enough once a part of it is replaced."""
    line, stop = _line(source, start, end)
    return stop - line - (end - start) + len(new) <= LONGEST_LINE


def _line(source: Source, start: int, end: int) -> tuple[int, int]:
    """Return where the line of a place begins, and where that of another ends."""
    stop = source.text.find("\n", end)
    return source.text.rfind("\n", 0, start) + 1, stop if stop >= 0 else len(source.text)


def without(source: Source, statement: ast.stmt) -> Replacement:
    """Return the replacement that takes the lines of a statement away."""
    start, end = source.line_span(statement)
    return start, end, ""


def above(source: Source, statement: ast.stmt, text: str) -> Replacement:
    """Return the replacement that puts lines above a statement."""
    start, _ = source.line_span(statement)
    return start, start, text


def below(source: Source, statement: ast.stmt, text: str) -> Replacement:
    """Return the replacement that puts lines below a statement."""
    _, end = source.line_span(statement)
    return end, end, text if source.text[:end].endswith("\n") else f"\n{text}"


def into_init(source: Source, init: Function, text: str, before: str = "self.register_") -> Replacement:
    """Return the replacement that puts lines into `init_task`: above the first statement that begins so, or at its end."""
    for statement in body_of(init):
        if isinstance(statement, ast.Expr) and ast.unparse(statement).startswith(before):
            return above(source, statement, text)
    return below(source, init.body[-1], text)


def docstring(text: str, indent: str) -> str:
    """Return a docstring, its first line not indented."""
    safe = text.strip().replace("\\", "\\\\").replace('"""', '\\"\\"\\"')
    if safe.endswith('"'):
        safe = f'{safe[:-1]}\\"'
    lines = safe.split("\n")
    if len(lines) == 1:
        return f'"""{safe}"""'
    rest = "\n".join(f"{indent}{line}".rstrip() for line in lines[1:])
    return f'"""{lines[0]}\n{rest}\n{indent}"""'
