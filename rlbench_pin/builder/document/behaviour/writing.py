"""How Python is laid out: lists on one line or several, statements that come and go, docstrings."""

from __future__ import annotations

import ast
from collections.abc import Sequence

from rlbench_pin.builder.document.behaviour.source import Function, Replacement, Source
from rlbench_pin.builder.document.behaviour.task_class import body_of

LONGEST_LINE = 130
INDENT = "    "


def listed(parts: Sequence[str], before: str, behind: str = "", brackets: str = "[]") -> str:
    """Return a list on one line, or with each part on its own line where it would be too long.

    Args:
        parts: What is in it.
        before: What stands before it in its line, indentation included.
        behind: What stands behind it.
        brackets: Those around it.
    """
    comma = "," if brackets == "()" and len(parts) == 1 else ""
    line = f"{brackets[0]}{', '.join(parts)}{comma}{brackets[1]}"
    if len(before) + len(line) + len(behind) <= LONGEST_LINE and "\n" not in line:
        return line
    indent = before[: len(before) - len(before.lstrip())]
    inner = "".join(f"{indent}{INDENT}{part},\n" for part in parts)
    return f"{brackets[0]}\n{inner}{indent}{brackets[1]}"


def call_of_list(call: str, parts: Sequence[str], indent: str) -> str:
    """Return the statement `call([...])`, laid out as a formatter does."""
    line = f"{indent}{call}([{', '.join(parts)}])"
    if len(line) <= LONGEST_LINE and "\n" not in line:
        return line
    deeper = f"{indent}{INDENT}"
    return f"{indent}{call}(\n{deeper}{listed(parts, deeper)}\n{indent})"


def new_list(source: Source, node: ast.List | ast.Tuple, old: Sequence[str], new: Sequence[str]) -> list[Replacement]:
    """Return what to replace so that a list has other parts; those that stay in their places keep their bytes."""
    if len(old) == len(new):
        places = [source.span(part) for part in node.elts]
        return [(*place, b) for place, a, b in zip(places, old, new, strict=True) if a != b]
    start, end = source.span(node)
    line = source.text.rfind("\n", 0, start) + 1
    stop = source.text.find("\n", end)
    behind = source.text[end : stop if stop >= 0 else len(source.text)]
    brackets = "()" if isinstance(node, ast.Tuple) else "[]"
    return [(start, end, listed(new, source.text[line:start], behind, brackets))]


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


def indent_of(source: Source, statement: ast.stmt) -> str:
    """Return the indentation of a statement."""
    return " " * statement.col_offset


def into_init(source: Source, init: Function, text: str) -> Replacement:
    """Return the replacement that puts lines into `init_task`: above the first registration, or at its end."""
    for statement in body_of(init):
        if isinstance(statement, ast.Expr) and ast.unparse(statement).startswith("self.register_"):
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
