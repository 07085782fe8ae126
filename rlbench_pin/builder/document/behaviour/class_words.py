"""What a class of a task says of itself: title, description, number of variations, switches."""

from __future__ import annotations

import ast

from rlbench_pin.builder.document.behaviour.source import Source
from rlbench_pin.builder.document.behaviour.task_class import TaskClass, only_return
from rlbench_pin.builder.document.behaviour.writing import above, below, docstring


def read_docstring(node: ast.Module | ast.ClassDef) -> str | None:
    """Return the docstring of a module or a class, None when there is none."""
    return ast.get_docstring(node)


def written_docstring(source: Source, node: ast.Module | ast.ClassDef, text: str) -> str:
    """Return the Python with another docstring."""
    first = node.body[0]
    indent = " " * first.col_offset
    new = docstring(text, indent)
    if ast.get_docstring(node) is None:
        return source.edited([above(source, first, f"{indent}{new}\n\n")])
    return source.edited([(*source.span(first), new)])


def read_count(task: TaskClass) -> int | None:
    """Return the number of variations; None when it is computed."""
    method = task.method("variation_count")
    if method is None:
        return 1
    answer = only_return(method)
    value = answer.value if answer is not None else None
    return value.value if isinstance(value, ast.Constant) and type(value.value) is int else None


def written_count(task: TaskClass, count: int) -> str:
    """Return the Python with another number of variations, which has to be written out now."""
    source, method = task.source, task.method("variation_count")
    if method is not None:
        answer = only_return(method)
        if count == 1:
            start, end = source.line_span(method)
            while source.text[end : end + 1] == "\n":
                end += 1
            return source.edited([(start, end, "")])
        return source.edited([(*source.span(answer.value), str(count))] if answer is not None and answer.value else [])
    lines = ["def variation_count(self) -> int:", '    """Return how many variations there are."""', f"    return {count}"]
    text = "".join(f"    {line}\n" for line in lines)
    episode = task.method("init_episode")
    if episode is not None:
        return source.edited([above(source, episode, f"{text}\n")])
    return source.edited([below(source, task.node.body[-1], f"\n{text}")])


def read_flag(task: TaskClass, name: str) -> bool | None:
    """Return a switch of the class, false when it is not there; None when it is computed."""
    value = _flag(task, name)
    if value is None:
        return False
    node = value.value
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, bool) else None


def written_flag(task: TaskClass, name: str, value: bool) -> str:
    """Return the Python in which a switch of the class is on or off."""
    source, node = task.source, _flag(task, name)
    if node is not None and value and node.value is not None:
        return source.edited([(*source.span(node.value), "True")])
    if node is not None:
        start, end = source.line_span(node)
        if source.text[end : end + 1] == "\n" and source.text[:start].endswith("\n\n"):
            end += 1
        return source.edited([(start, end, "")])
    first = task.node.body[0]
    if ast.get_docstring(task.node, clean=False) is None:
        return source.edited([above(source, first, f"    {name} = {value}\n\n")])
    return source.edited([below(source, first, f"\n    {name} = {value}\n")])


def _flag(task: TaskClass, name: str) -> ast.Assign | ast.AnnAssign | None:
    for node in task.node.body:
        targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
        if isinstance(node, ast.Assign | ast.AnnAssign) and [ast.unparse(target) for target in targets] == [name]:
            return node
    return None
