"""The sentences of a task: one list for all variations, or one for each."""

from __future__ import annotations

import ast
import re
from collections.abc import Sequence
from dataclasses import dataclass

from rlbench_pin.builder.document.behaviour.expressions import quoted
from rlbench_pin.builder.document.behaviour.source import Replacement, Source, text_of
from rlbench_pin.builder.document.behaviour.task_class import Binding, TaskClass, only_return
from rlbench_pin.builder.document.behaviour.writing import INDENT, above, listed, new_list, without

Sentences = tuple[tuple[str, ...], ...]
"""One group for all variations, or one for each."""
Groups = list[ast.List | ast.Tuple]
_PLAIN_F_STRING = re.compile(r"""f(["'])(?!\1)(.*)\1""")
_FIELD = re.compile(r"\{([^{}]*)\}")
_TABLE = "SENTENCES"


@dataclass(frozen=True, eq=False)
class _Said:
    """Where the sentences stand."""

    answer: ast.Return
    groups: Groups
    table: Binding | None

    @property
    def fields(self) -> set[str]:
        """What f-strings among them have filled in."""
        return {field for group in self.groups for item in group.elts for field in _fields(item)}


def read_sentences(task: TaskClass) -> Sentences | None:
    """Return the sentences; None when they are not written out."""
    said = _said(task)
    if said is None:
        return None
    groups = tuple(tuple(_sentence(task.source, item) for item in group.elts) for group in said.groups)
    if any(sentence is None for group in groups for sentence in group):
        return None
    return tuple(tuple(sentence or "" for sentence in group) for group in groups)


def written_sentences(task: TaskClass, new: Sequence[Sequence[str]]) -> str | None:
    """Return the Python with other sentences; None when it cannot say them."""
    said = _said(task)
    if said is None:
        return None
    if said.table is None and len(new) == 1 or said.table is not None and len(new) == len(said.groups):
        changes: list[Replacement] = []
        for node, sentences in zip(said.groups, new, strict=True):
            before = [task.source.part(item) for item in node.elts]
            changes += new_list(task.source, node, before, _texts(task.source, said, sentences))
        return task.source.edited(changes)
    return _in_one_list(task, said, new[0]) if len(new) == 1 else _in_table(task, said, new)


def _in_one_list(task: TaskClass, said: _Said, sentences: Sequence[str]) -> str:
    """Return one list for all variations instead of a table."""
    head = f"{' ' * said.answer.col_offset}return "
    answer = f"return {listed(_texts(task.source, said, sentences), head)}"
    found = [(*task.source.span(said.answer), answer)]
    if said.table is not None and said.table.is_alone:
        start, end, _ = without(task.source, said.table.statement)
        behind = task.source.text[end:]
        end += len(behind) - len(behind.lstrip("\n")) if behind.startswith("\n") else 0
        found.append((start, end, ""))
    return task.source.edited(found)


def _in_table(task: TaskClass, said: _Said, new: Sequence[Sequence[str]]) -> str | None:
    """Return a table with a list for each variation, which `return` looks up."""
    source = task.source
    groups = [_texts(source, said, sentences) for sentences in new]
    if said.table is None and any(text.startswith("f") for group in groups for text in group):
        return None
    if said.table is not None:
        indent = INDENT if said.table.statement.col_offset else ""
        return source.edited([(*source.span(said.table.value), _table(groups, indent))])
    table = f'{_TABLE} = {_table(groups, "")}\n"""What is said in each variation."""\n\n\n'
    answer = f"return {_TABLE}[{_variation(task)}]"
    return source.edited([above(source, task.node, table), (*source.span(said.answer), answer)])


def _table(groups: Sequence[Sequence[str]], indent: str) -> str:
    deeper = indent + INDENT
    return "(\n" + "".join(f"{deeper}{listed(group, deeper, ',')},\n" for group in groups) + f"{indent})"


def _said(task: TaskClass) -> _Said | None:
    method = task.method("init_episode")
    answer = only_return(method) if method is not None else None
    if method is None or answer is None or answer.value is None:
        return None
    value = answer.value
    if isinstance(value, ast.List):
        return _Said(answer, [value], None)
    if not isinstance(value, ast.Subscript) or ast.unparse(value.slice) != _variation(task):
        return None
    table = task.bindings(method).get(ast.unparse(value.value))
    groups = _groups(table.value) if table is not None else None
    return None if table is None or groups is None or len(groups) < 2 else _Said(answer, groups, table)


def _groups(node: ast.expr) -> Groups | None:
    """Return the lists of a table with one for each variation."""
    items: Sequence[ast.expr | None] = []
    if isinstance(node, ast.List | ast.Tuple):
        items = node.elts
    if isinstance(node, ast.Dict):
        keys = [key.value if isinstance(key, ast.Constant) else None for key in node.keys]
        items = node.values if keys == list(range(len(keys))) else []
    found = [item for item in items if isinstance(item, ast.List | ast.Tuple)]
    return found if found and len(found) == len(items) else None


def _variation(task: TaskClass) -> str:
    method = task.method("init_episode")
    names = [argument.arg for argument in method.args.args] if method is not None else []
    return names[1] if len(names) > 1 else "variation"


def _sentence(source: Source, node: ast.expr) -> str | None:
    """Return a sentence as people read it; `{...}` in an f-string stays as it is written."""
    plain = text_of(node)
    if plain is not None or not isinstance(node, ast.JoinedStr):
        return plain
    found = _PLAIN_F_STRING.fullmatch(source.part(node))
    return found[2] if found is not None and "\\" not in found[2] else None


def _fields(node: ast.expr) -> set[str]:
    parts = node.values if isinstance(node, ast.JoinedStr) else []
    return {ast.unparse(part.value) for part in parts if isinstance(part, ast.FormattedValue)}


def _texts(source: Source, said: _Said, sentences: Sequence[str]) -> list[str]:
    """Write sentences as Python; those that are there already keep their text."""
    known = {_sentence(source, item): source.part(item) for group in said.groups for item in group.elts}
    return [known.get(sentence) or _written(sentence, said.fields) for sentence in sentences]


def _written(sentence: str, fields: set[str]) -> str:
    """Return a sentence as Python: an f-string when it has fields that other sentences have."""
    said = [field.partition(":")[0].partition("!")[0] for field in _FIELD.findall(sentence)]
    if not said or not set(said) <= fields:
        return quoted(sentence)
    quote = "'" if '"' in sentence else '"'
    return f"f{quote}{sentence}{quote}"
