"""The list of conditions that a task registers: what forms show of it, and how they change it."""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rlbench_pin.builder.document.forms import (
    Argument,
    ConditionForm,
    Named,
    Reader,
    Written,
    expression,
    list_expression,
    number_text,
)
from rlbench_pin.builder.document.python_text import Binding, ListNode, TaskClass, laid_out, one_line
from rlbench_pin.builder.document.texts import Replacement, replaced

Conditions = tuple[ConditionForm | Written, ...]
SUCCESS, FAILURE = "register_success_conditions", "register_fail_conditions"
"""Calls that register conditions."""


@dataclass(frozen=True, eq=False)
class _Registered:
    """The one call in which a task registers conditions, and its list."""

    call: ast.Call
    items: ListNode
    reader: Reader

    def forms(self) -> Conditions:
        return tuple(self._form(item) for item in self.items.elts)

    def _form(self, item: ast.expr) -> ConditionForm | Written:
        found = self.reader.read(item) if not isinstance(item, ast.Starred) else None
        return found if isinstance(found, ConditionForm) else Written(self.reader.source.part(item))


def read_conditions(task: TaskClass, register: str) -> Conditions | None:
    """Return the conditions that a task registers; None unless it does so once, with a literal list."""
    found = _registered(task, register)
    if found is None:
        return () if not task.calls(register) else None
    return found.forms()


def with_conditions(task: TaskClass, register: str, new: Sequence[ConditionForm | Written]) -> str:
    """Return the Python in which a task registers other conditions."""
    found, source = _registered(task, register), task.source
    if found is None:
        names = Reader(source, task.bindings(task.init)).elements_above(source.line_count + 1)
        call = laid_out(f"self.{register}({list_expression(new, names)})", task.init_indent, len(task.init_indent))
        return source.edited([source.below(task.init.body[-1], f"{task.init_indent}{call}\n")])
    statement = next((n for n in ast.walk(task.node) if isinstance(n, ast.Expr) and n.value is found.call), None)
    if not new and register == FAILURE and statement is not None:
        return source.edited([source.without(statement)])
    old, names = found.forms(), found.reader.elements_above(found.call.lineno)
    texts, free = _kept(old, new, [source.part(item) for item in found.items.elts])
    changes: list[Replacement] = []
    for place, form in enumerate(new):
        if texts[place]:
            continue
        patch = _patch(found.reader, found.items.elts[place], old[place], form, names) if place in free else None
        texts[place], more = (expression(form, names), []) if patch is None else patch
        changes += more
    return source.edited([*changes, *_new_items(found, texts)])


def _registered(task: TaskClass, register: str) -> _Registered | None:
    calls = task.calls(register)
    if len(calls) != 1 or len(calls[0].args) != 1 or not isinstance(calls[0].args[0], ListNode):
        return None
    reader = Reader(task.source, task.bindings(task.function_around(calls[0])))
    return _Registered(calls[0], calls[0].args[0], reader)


def _kept(old: Sequence[object], new: Sequence[object], before: Sequence[str]) -> tuple[list[str], set[int]]:
    """Return the texts of conditions that exist already, perhaps elsewhere, and the old places that are left."""
    texts, free = [""] * len(new), set(range(len(old)))
    for place, form in enumerate(new):
        if place in free and old[place] == form:
            texts[place] = before[place]
            free.remove(place)
    for place, form in enumerate(new):
        moved = next((k for k in sorted(free) if old[k] == form), None)
        if not texts[place] and moved is not None:
            texts[place] = before[moved]
            free.remove(moved)
    return texts, free


def _new_items(found: _Registered, texts: list[str]) -> list[Replacement]:
    """Return the replacements for other items of the list; the call is laid out anew where its lines change."""
    source = found.reader.source
    changed = source.new_list(found.items, texts)
    start, end = source.span(found.call)
    indent = source.indent_before(start)
    is_new_list = bool(changed) and changed[0][0] == source.span(found.items)[0]
    if indent.strip() or any("\n" in one_line(text) for text in texts) or (changed and not is_new_list):
        return changed
    call = f"{source.part(found.call.func)}([{', '.join(map(one_line, texts))}])"
    return [(start, end, laid_out(call, indent, len(indent)))] if changed else []


def _patch(
    reader: Reader, node: ast.expr, old: Argument, new: Argument, names: Mapping[Named, str]
) -> tuple[str, list[Replacement]] | None:
    """Change arguments of a condition in place.

    Returns:
        The text of the condition in the list, and replacements elsewhere; None when it is another condition.
    """
    if not isinstance(old, ConditionForm) or not isinstance(new, ConditionForm) or old.kind != new.kind:
        return None
    bound = _bound(reader, node)
    call = bound.value if bound is not None else node
    given = reader.arguments(call, new.kind) if isinstance(call, ast.Call) else None
    if not isinstance(call, ast.Call):
        return None
    start, end = reader.source.span(call)
    if given is None or not given.keys() >= new.arguments.keys() >= old.arguments.keys():
        found = [(start, end, expression(new, names))]
    else:
        found = [
            (*reader.source.span(given[name]), _argument(reader, given[name], value, names))
            for name, value in new.arguments.items()
            if value != old.arguments.get(name)
        ]
    if bound is not None:
        return reader.source.part(node), found
    return replaced(reader.source.part(call), [(first - start, last - start, text) for first, last, text in found]), []


def _bound(reader: Reader, node: ast.expr) -> Binding | None:
    """Return the assignment that a name stands for, through other names."""
    bound = reader.bindings.get(ast.unparse(node)) if isinstance(node, ast.Name | ast.Attribute) else None
    return None if bound is None else _bound(reader, bound.value) or bound


def _argument(reader: Reader, node: ast.expr, value: Argument, names: Mapping[Named, str]) -> str:
    """Return the text of an argument; degrees stay degrees, and items of a list that exist already keep their text."""
    if isinstance(value, float):
        return number_text(value, reader.source.part(node))
    if isinstance(value, tuple) and isinstance(node, ListNode):
        old = reader.read(node)
        if isinstance(old, tuple) and len(old) == len(node.elts):
            there = list(zip(old, map(reader.source.part, node.elts), strict=True))
            parts = [next((text for form, text in there if form == item), None) or expression(item, names) for item in value]
            return f"[{', '.join(parts)}]"
    return expression(value, names)
