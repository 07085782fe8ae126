"""What the hand of a task may hold."""

from __future__ import annotations

import ast
from collections.abc import Sequence

from rlbench_pin.builder.document.behaviour.expressions import quoted
from rlbench_pin.builder.document.behaviour.source import text_of
from rlbench_pin.builder.document.behaviour.task_class import TaskClass
from rlbench_pin.builder.document.behaviour.writing import into_init, listed, new_list, without

REGISTER = "register_graspable_objects"


def read_graspable(task: TaskClass) -> tuple[str, ...] | None:
    """Return the names that a task registers; None when they are not written out in one place."""
    calls = task.calls(REGISTER)
    if not calls:
        return ()
    items = _items(calls)
    names = [text_of(item) for item in items.elts] if items is not None else [None]
    return None if None in names else tuple(name for name in names if name is not None)


def written_graspable(task: TaskClass, names: Sequence[str]) -> str | None:
    """Return the Python that registers other names; None when it cannot."""
    source, init, calls = task.source, task.method("init_task"), task.calls(REGISTER)
    assert init is not None, "a task class is found by its init_task"
    texts = [quoted(name) for name in names]
    if not calls:
        indent = " " * init.body[0].col_offset
        call = f"{indent}self.{REGISTER}("
        return source.edited([into_init(source, init, f"{call}{listed(texts, call, ')')})\n")])
    items = _items(calls)
    if items is None:
        return None
    statement = next((s for s in init.body if isinstance(s, ast.Expr) and s.value is calls[0]), None)
    if not texts and statement is not None:
        return source.edited([without(source, statement)])
    return source.edited(new_list(source, items, [source.part(item) for item in items.elts], texts))


def _items(calls: list[ast.Call]) -> ast.List | ast.Tuple | None:
    argument = calls[0].args[0] if len(calls) == 1 and len(calls[0].args) == 1 else None
    return argument if isinstance(argument, ast.List | ast.Tuple) else None
