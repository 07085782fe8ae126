"""Names of a task that an edit has left without use."""

from __future__ import annotations

import ast

from rlbench_pin.builder.document.behaviour.expressions import named_thing
from rlbench_pin.builder.document.behaviour.kinds import kind_of
from rlbench_pin.builder.document.behaviour.source import Function, Source
from rlbench_pin.builder.document.behaviour.writing import without


def tidied(old: Source, text: str) -> str:
    """Return a text without assignments of things and conditions that were used before an edit and are not any more.

    Attributes of the task that are things of the scene stay, for they are at the service of the whole class.

    Args:
        old: The Python before the edit.
        text: The Python after it.
    """
    used_before = _used(old)
    while True:
        new = Source(text)
        idle = used_before - _used(new)
        gone = [statement for statement in _assignments(new) if ast.unparse(statement.targets[0]) in idle]
        if not gone:
            return text
        text = new.edited(without(new, statement) for statement in gone)


def _assignments(source: Source) -> list[ast.Assign]:
    """Return plain assignments of things and conditions within methods."""
    return [
        node
        for function in ast.walk(source.tree)
        if isinstance(function, Function)
        for node in function.body
        if isinstance(node, ast.Assign) and len(node.targets) == 1 and _may_go(node.targets[0], node.value)
    ]


def _may_go(target: ast.expr, value: ast.expr) -> bool:
    is_condition = isinstance(value, ast.Call) and isinstance(value.func, ast.Name) and kind_of(value.func.id) is not None
    return is_condition or (isinstance(target, ast.Name) and named_thing(value) is not None)


def _used(source: Source) -> set[str]:
    return {
        ast.unparse(node)
        for node in ast.walk(source.tree)
        if isinstance(node, ast.Name | ast.Attribute) and isinstance(node.ctx, ast.Load)
    }
