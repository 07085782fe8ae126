"""The class of a task in its Python: its methods, and what its names stand for."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from rlbench_pin.builder.document.behaviour.source import Function, Source


@dataclass(frozen=True, eq=False)
class Binding:
    """What a name stands for that is assigned once."""

    value: ast.expr
    """What it was assigned."""
    statement: ast.stmt
    """Where."""
    is_alone: bool
    """Whether the statement assigns nothing else."""


class TaskClass:
    """The class of a task.

    Args:
        source: The Python, with one class that has `init_task`.
    """

    def __init__(self, source: Source, node: ast.ClassDef) -> None:
        self.source, self.node = source, node

    @classmethod
    def of(cls, source: Source) -> TaskClass | None:
        """Return the class that has `init_task`; None when there is none, or more than one."""
        found = [node for node in source.tree.body if isinstance(node, ast.ClassDef) and _method(node, "init_task") is not None]
        return cls(source, found[0]) if len(found) == 1 else None

    def method(self, name: str) -> Function | None:
        """Return a method, None when there is none."""
        return _method(self.node, name)

    def calls(self, name: str) -> list[ast.Call]:
        """Return the calls of a method of the task, `self.<name>(...)`, anywhere in the class."""
        return [node for node in ast.walk(self.node) if isinstance(node, ast.Call) and is_own(node.func, name)]

    def function_around(self, node: ast.AST) -> Function | None:
        """Return the method in which something stands."""
        for function in self.node.body:
            if isinstance(function, Function) and any(part is node for part in ast.walk(function)):
                return function
        return None

    def bindings(self, function: Function | None) -> dict[str, Binding]:
        """Return what names stand for in a method: constants, attributes from `init_task`, local names; as they are written."""
        local = dict(_once(_assignments(function.body), function)) if function is not None else {}
        return {**self._lasting, **{name: bound for name, bound in local.items() if "." not in name}}

    @cached_property
    def _lasting(self) -> dict[str, Binding]:
        init = self.method("init_task")
        constants = dict(_once(_assignments(self.source.tree.body), self.source.tree))
        own = {f"self.{name}": bound for name, bound in _once(_assignments(self.node.body), self.node)}
        kept = dict(_once(_assignments(init.body), self.node)) if init is not None else {}
        return {**constants, **own, **{name: bound for name, bound in kept.items() if name.startswith("self.")}}


def is_own(node: ast.expr, name: str) -> bool:
    """Whether an expression is `self.<name>`."""
    return isinstance(node, ast.Attribute) and node.attr == name and isinstance(node.value, ast.Name) and node.value.id == "self"


def body_of(function: Function) -> list[ast.stmt]:
    """Return the statements of a method behind its docstring."""
    return function.body[1:] if ast.get_docstring(function, clean=False) is not None else function.body


def only_return(method: Function) -> ast.Return | None:
    """Return the last statement of a method, when it is its only return."""
    returns = [node for node in ast.walk(method) if isinstance(node, ast.Return)]
    body = body_of(method)
    return returns[0] if len(returns) == 1 and body and body[-1] is returns[0] else None


def _method(node: ast.ClassDef, name: str) -> Function | None:
    return next((part for part in node.body if isinstance(part, Function) and part.name == name), None)


def _assignments(body: Sequence[ast.stmt]) -> Iterator[tuple[str, Binding]]:
    """Yield what statements assign, those of tuples to tuples one by one."""
    for statement in body:
        if isinstance(statement, ast.AnnAssign) and statement.value is not None:
            yield ast.unparse(statement.target), Binding(statement.value, statement, True)
        if not isinstance(statement, ast.Assign) or len(statement.targets) != 1:
            continue
        target, value = statement.targets[0], statement.value
        if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple) and len(target.elts) == len(value.elts):
            for name, part in zip(target.elts, value.elts, strict=True):
                yield ast.unparse(name), Binding(part, statement, False)
        elif not isinstance(target, ast.Tuple):
            yield ast.unparse(target), Binding(value, statement, True)


def _once(found: Iterator[tuple[str, Binding]], scope: ast.AST) -> Iterator[tuple[str, Binding]]:
    """Leave out names that are assigned more than once in a scope."""
    stores = Counter(
        ast.unparse(node)
        for node in ast.walk(scope)
        if isinstance(node, ast.Name | ast.Attribute) and isinstance(node.ctx, ast.Store | ast.Del)
    )
    for name, bound in found:
        if stores[name] == 1:
            yield name, bound
