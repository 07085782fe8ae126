"""Things of the scene that forms name more than once get an attribute, as a person would write it."""

from __future__ import annotations

import ast
from collections import Counter
from keyword import iskeyword

from rlbench_pin.builder.document.behaviour.conditions import FAILURE, SUCCESS
from rlbench_pin.builder.document.behaviour.expressions import expression, named_thing
from rlbench_pin.builder.document.behaviour.forms import Named
from rlbench_pin.builder.document.python_text.layout import laid_out, one_line
from rlbench_pin.builder.document.python_text.source import Replacement, Source
from rlbench_pin.builder.document.python_text.task_class import TaskClass, body_of
from rlbench_pin.builder.document.python_text.writing import above
from rlbench_pin.tasks import Task

_TAKEN = frozenset({"world", "robot", "gripper", "round"})


def with_attributes(old: Source, text: str) -> str:
    """Return a text in which a thing that an edit has named once more, in what forms write, is looked up once.

    Args:
        old: The Python before the edit.
        text: The Python after it.
    """
    source = Source(text)
    task, before = TaskClass.of(source), TaskClass.of(old)
    init = task.method("init_task") if task is not None else None
    if task is None or before is None or init is None or not body_of(init):
        return text
    places, known = _places(task), Counter(thing for thing, _ in _places(before))
    counts = Counter(thing for thing, _ in places)
    chosen = [thing for thing, n in counts.items() if n > max(1, known[thing]) and _is_free(task, thing.name)]
    if not chosen:
        return text
    indent = " " * init.body[0].col_offset
    lines = "".join(f"{indent}self.{thing.name} = {expression(thing, {})}\n" for thing in chosen)
    found: list[Replacement] = [above(source, body_of(init)[0], lines)]
    found += [(*source.span(node), f"self.{thing.name}") for thing, node in places if thing in chosen]
    return _closed_up(source.edited(found))


def _places(task: TaskClass) -> list[tuple[Named, ast.Call]]:
    """Return where forms name things: in conditions, and in what is placed at random."""
    calls = [*task.calls(SUCCESS), *task.calls(FAILURE)]
    calls += [
        node
        for node in ast.walk(task.node)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "sample"
    ]
    found = [(named_thing(node), node) for call in calls for node in ast.walk(call) if isinstance(node, ast.Call)]
    return [(thing, node) for thing, node in found if thing is not None and thing.kind != "joint"]


def _is_free(task: TaskClass, name: str) -> bool:
    """Whether a task has no attribute of that name."""
    own = {node.attr for node in ast.walk(task.node) if isinstance(node, ast.Attribute)}
    own |= {node.name for node in ast.walk(task.node) if isinstance(node, ast.FunctionDef)}
    own |= {node.id for node in ast.walk(task.node) if isinstance(node, ast.Name)}
    return name not in own | _TAKEN and not hasattr(Task, name) and not iskeyword(name)


def _closed_up(text: str) -> str:
    """Lay registrations out again that have become short enough for one line."""
    source = Source(text)
    task = TaskClass.of(source)
    found: list[Replacement] = []
    for call in [*task.calls(SUCCESS), *task.calls(FAILURE)] if task is not None else []:
        start, end = source.span(call)
        indent = source.text[source.text.rfind("\n", 0, start) + 1 : start]
        if not indent.strip() and "#" not in source.part(call):
            found.append((start, end, laid_out(one_line(source.part(call)), indent, len(indent))))
    return source.edited(found)
