"""The list of conditions that a task registers: what forms show of it, and how they change it."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from rlbench_pin.builder.document.behaviour.expressions import Reader, expression, named_thing, number_text
from rlbench_pin.builder.document.behaviour.forms import Argument, ConditionForm, Named, Written
from rlbench_pin.builder.document.behaviour.source import Replacement, Source
from rlbench_pin.builder.document.behaviour.task_class import Binding, TaskClass
from rlbench_pin.builder.document.behaviour.writing import call_of_list, into_init, new_list

Conditions = tuple[ConditionForm | Written, ...]
SUCCESS, FAILURE = "register_success_conditions", "register_fail_conditions"
"""Calls that register conditions."""


@dataclass(frozen=True, eq=False)
class _Registered:
    """The one place where a task registers conditions."""

    call: ast.Call
    items: ast.List | ast.Tuple
    reader: Reader


def read_conditions(task: TaskClass, register: str) -> Conditions | None:
    """Return the conditions that a task registers; None when it does not do so once, with a list that is written out."""
    found = _registered(task, register)
    if found is None:
        return () if not task.calls(register) else None
    return tuple(_shown(found.reader, item) for item in found.items.elts)


def written_conditions(task: TaskClass, register: str, new: Sequence[ConditionForm | Written]) -> str:
    """Return the Python in which a task registers other conditions."""
    found = _registered(task, register)
    if found is None:
        return _first(task, register, new)
    source, old = task.source, [_shown(found.reader, item) for item in found.items.elts]
    names = _names_before(found)
    before = [source.part(item) for item in found.items.elts]
    texts: list[str] = [""] * len(new)
    changes: list[Replacement] = []
    free = _kept(old, new, before, texts)
    for place, form in enumerate(new):
        if texts[place]:
            continue
        patch = _patch(found.reader, found.items.elts[place], old[place], form, names) if place in free else None
        texts[place], more = (expression(form, names), []) if patch is None else patch
        changes += more
    return source.edited([*changes, *_new_items(source, found, before, texts)])


def _kept(old: Sequence[object], new: Sequence[object], before: Sequence[str], texts: list[str]) -> set[int]:
    """Fill in the text of conditions that are there already, perhaps elsewhere; return the places of those that are left."""
    free = set(range(len(old)))
    for place, form in enumerate(new):
        if place in free and old[place] == form:
            texts[place] = before[place]
            free.remove(place)
    for place, form in enumerate(new):
        moved = next((k for k in sorted(free) if old[k] == form), None)
        if not texts[place] and moved is not None:
            texts[place] = before[moved]
            free.remove(moved)
    return free


def _new_items(source: Source, found: _Registered, before: list[str], texts: list[str]) -> list[Replacement]:
    if len(before) == len(texts):
        return new_list(source, found.items, before, texts)
    line = source.text[source.text.rfind("\n", 0, source.span(found.call)[0]) + 1 : source.span(found.call)[0]]
    if line.strip():
        return new_list(source, found.items, before, texts)
    statement = call_of_list(source.part(found.call.func), texts, line)
    return [(*source.span(found.call), statement.removeprefix(line))]


def _registered(task: TaskClass, register: str) -> _Registered | None:
    calls = task.calls(register)
    if len(calls) != 1 or len(calls[0].args) != 1 or not isinstance(calls[0].args[0], ast.List | ast.Tuple):
        return None
    function = task.function_around(calls[0])
    reader = Reader(task.source, task.bindings(function))
    return _Registered(calls[0], calls[0].args[0], reader)


def _shown(reader: Reader, item: ast.expr) -> ConditionForm | Written:
    """Return a condition, or the text of what is none that a form can show."""
    if not isinstance(item, ast.Starred):
        found = reader.read(item)
        if isinstance(found, ConditionForm):
            return found
    return Written(reader.source.part(item))


def _first(task: TaskClass, register: str, new: Sequence[ConditionForm | Written]) -> str:
    init = task.method("init_task")
    assert init is not None, "a task class is found by its init_task"
    reader = Reader(task.source, task.bindings(init))
    end = task.source.line_span(init)[1]
    names = dict(_things(reader, task.source.line_count + 1))
    line = call_of_list(f"self.{register}", [expression(form, names) for form in new], " " * init.body[0].col_offset)
    if register != SUCCESS:
        return task.source.edited([into_init(task.source, init, f"{line}\n")])
    return task.source.edited([(end, end, f"{line}\n" if task.source.text[:end].endswith("\n") else f"\n{line}\n")])


def _names_before(found: _Registered) -> dict[Named, str]:
    return dict(_things(found.reader, found.call.lineno))


def _things(reader: Reader, last_line: int) -> Iterator[tuple[Named, str]]:
    """Yield the things of the scene that have names of their own in the Python above a line, those of `self` last."""
    bound = sorted(reader.bindings.items(), key=lambda item: item[0].startswith("self."))
    for name, binding in bound:
        thing = named_thing(binding.value)
        if thing is not None and binding.statement.lineno < last_line:
            yield thing, name


def _patch(
    reader: Reader, node: ast.expr, old: Argument, new: Argument, names: dict[Named, str]
) -> tuple[str, list[Replacement]] | None:
    """Change arguments of a condition where they stand.

    Returns:
        The text of the condition in the list, and what to replace elsewhere; None when it is another condition.
    """
    if not isinstance(old, ConditionForm) or not isinstance(new, ConditionForm) or old.kind != new.kind:
        return None
    bound = _bound(reader, node)
    call = bound.value if bound is not None else node
    if not isinstance(call, ast.Call):
        return None
    given = reader.arguments(call, new.kind)
    if (
        given is None
        or any(name not in given for name in new.arguments)
        or any(name not in new.arguments for name in old.arguments)
    ):
        text = expression(new, names)
        return (text, []) if bound is None else (reader.source.part(node), [(*reader.source.span(call), text)])
    found = [
        (*reader.source.span(given[name]), _argument(reader, given[name], value, names))
        for name, value in new.arguments.items()
        if value != old.arguments.get(name)
    ]
    if bound is not None:
        return reader.source.part(node), found
    start, _ = reader.source.span(call)
    text = reader.source.part(call)
    for first, last, part in sorted(found, reverse=True):
        text = f"{text[: first - start]}{part}{text[last - start :]}"
    return text, []


def _bound(reader: Reader, node: ast.expr) -> Binding | None:
    """Return the assignment that a name stands for, through other names."""
    bound = reader.bindings.get(ast.unparse(node)) if isinstance(node, ast.Name | ast.Attribute) else None
    return None if bound is None else _bound(reader, bound.value) or bound


def _argument(reader: Reader, node: ast.expr, value: Argument, names: dict[Named, str]) -> str:
    if isinstance(value, float | int) and not isinstance(value, bool):
        return number_text(value, reader.source.part(node)) if isinstance(value, float) else repr(value)
    if isinstance(value, tuple) and isinstance(node, ast.List | ast.Tuple):
        old = reader.read(node)
        if isinstance(old, tuple) and len(old) == len(node.elts):
            there = list(zip(old, map(reader.source.part, node.elts), strict=True))
            parts = [next((text for form, text in there if form == item), None) or expression(item, names) for item in value]
            return f"[{', '.join(parts)}]"
    return expression(value, names)
