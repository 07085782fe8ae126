"""What a task imports from `rlbench_pin.tasks`: what it uses after an edit, sorted as a formatter does."""

from __future__ import annotations

import ast
from collections.abc import Iterable

from rlbench_pin import tasks
from rlbench_pin.builder.document.behaviour.source import Source
from rlbench_pin.builder.document.behaviour.writing import LONGEST_LINE

HOME = "rlbench_pin.tasks"


def with_imports(old: Source, text: str) -> str:
    """Return a text that imports what it uses of the tasks' vocabulary.

    Args:
        old: The Python before an edit; what it imports without need stays.
        text: The Python after it.

    Raises:
        PythonSyntaxError: It is no Python any more.
    """
    new = Source(text)
    used, bound = _used(new), _bound(new)
    missing = {name for name in used - bound if name in tasks.__all__}
    statement = next((node for node in new.tree.body if isinstance(node, ast.ImportFrom) and node.module == HOME), None)
    if statement is None:
        return new.edited([_first_import(new, missing)]) if missing else text
    idle = {alias.asname or alias.name for alias in statement.names} - used
    gone = idle & _used(old)
    if not missing and not gone:
        return text
    kept = [alias for alias in statement.names if (alias.asname or alias.name) not in gone]
    names = [f"{alias.name} as {alias.asname}" if alias.asname else alias.name for alias in kept]
    if not names and not missing:
        start, end = new.line_span(statement)
        return new.edited([(start, end, "")])
    return new.edited([(*new.span(statement), _statement([*names, *missing]))])


def _statement(names: Iterable[str]) -> str:
    """Write an import: constants, then classes, then functions."""
    ordered = sorted(names, key=lambda name: (0 if name.isupper() else 1 if name[:1].isupper() else 2, name))
    line = f"from {HOME} import {', '.join(ordered)}"
    if len(line) <= LONGEST_LINE:
        return line
    return f"from {HOME} import (\n{''.join(f'    {name},' + chr(10) for name in ordered)})"


def _first_import(new: Source, names: Iterable[str]) -> tuple[int, int, str]:
    """Put the import below all others, or below the docstring."""
    imports = [node for node in new.tree.body if isinstance(node, ast.Import | ast.ImportFrom)]
    if imports:
        _, end = new.line_span(imports[-1])
        gap = "\n" if isinstance(imports[-1], ast.ImportFrom) and imports[-1].module == "__future__" else ""
        return end, end, f"{gap}{_statement(names)}\n"
    first = new.tree.body[0] if new.tree.body and ast.get_docstring(new.tree) is not None else None
    at = new.line_span(first)[1] if first is not None else 0
    return at, at, f"\n{_statement(names)}\n" if first is not None else f"{_statement(names)}\n\n"


def _used(source: Source) -> set[str]:
    return {node.id for node in ast.walk(source.tree) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)}


def _bound(source: Source) -> set[str]:
    """Return the names that a module imports or defines."""
    found: set[str] = set()
    for node in ast.walk(source.tree):
        if isinstance(node, ast.Import | ast.ImportFrom):
            found |= {(alias.asname or alias.name).partition(".")[0] for alias in node.names}
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            found.add(node.name)
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            found.add(node.id)
    return found
