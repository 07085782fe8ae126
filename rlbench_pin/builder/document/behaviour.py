"""The parts of a task's Python file that forms can edit; the rest of the file keeps its bytes."""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from keyword import iskeyword
from typing import Any

from rlbench_pin.builder.document.conditions import (
    FAILURE,
    SUCCESS,
    ConditionForm,
    Conditions,
    Named,
    Written,
    check_form,
    expression,
    kind_of,
    named_element,
    read_conditions,
    with_conditions,
)
from rlbench_pin.builder.document.errors import EditRefused
from rlbench_pin.builder.document.placements import SpawnForm, read_placements, with_placements
from rlbench_pin.builder.document.python_text import (
    INDENT,
    Binding,
    Function,
    ListNode,
    PythonSyntaxError,
    Source,
    TaskClass,
    body_of,
    docstring,
    laid_out,
    listed,
    one_line,
    only_return,
    quoted,
    source_or_none,
    text_of,
    with_imports,
)
from rlbench_pin.builder.document.texts import Replacement
from rlbench_pin.errors import InvalidValue
from rlbench_pin.tasks import Task
from rlbench_pin.values import as_choice, as_flag, as_names, as_record, as_several, as_text, as_whole

Sentences = tuple[tuple[str, ...], ...]
"""One group for all variations, or one for each."""
_CHANCE, _GRASPABLE = "solved_by_chance", "register_graspable_objects"
_NAMING = ("graspable", "success", "failure", "placements")
"""Fields that name elements of the scene."""
_TAKEN = frozenset({"world", "robot", "gripper", "round"})
"""Attributes that a task has besides those of its class."""
_PLAIN_F_STRING = re.compile(r"""f(["'])(?!\1)(.*)\1""")
_ESCAPED_QUOTE = re.compile(r"""\\(["'])""")
_FIELD = re.compile(r"\{([^{}]*)\}")
_TABLE, _TABLE_WORDS = "SENTENCES", '"""Instructions of each variation."""'


# Docstrings and constants of the class ----------------------------------------------------------------------------------------


def _with_docstring(source: Source, node: ast.Module | ast.ClassDef, text: str) -> str:
    first = node.body[0]
    indent = " " * first.col_offset
    new = docstring(text, indent)
    if ast.get_docstring(node) is None:
        return source.edited([source.above(first, f"{indent}{new}\n\n")])
    return source.edited([(*source.span(first), new)])


def _read_count(task: TaskClass) -> int | None:
    """Return the number of variations; None when it is computed."""
    method = task.method("variation_count")
    if method is None:
        return 1
    answer = only_return(method)
    value = answer.value if answer is not None else None
    return value.value if isinstance(value, ast.Constant) and type(value.value) is int else None


def _with_count(task: TaskClass, count: int) -> str:
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
        return source.edited([source.above(episode, f"{text}\n")])
    return source.edited([source.below(task.node.body[-1], f"\n{text}")])


def _read_chance(task: TaskClass) -> bool | None:
    """Return the flag `solved_by_chance` of the class, False when it is missing; None when it is computed."""
    assignment = _chance(task)
    if assignment is None:
        return False
    node = assignment.value
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, bool) else None


def _with_chance(task: TaskClass, value: bool) -> str:
    source, node = task.source, _chance(task)
    if node is not None and value and node.value is not None:
        return source.edited([(*source.span(node.value), "True")])
    if node is not None:
        start, end = source.line_span(node)
        if source.text[end : end + 1] == "\n" and source.text[:start].endswith("\n\n"):
            end += 1
        return source.edited([(start, end, "")])
    first = task.node.body[0]
    if ast.get_docstring(task.node, clean=False) is None:
        return source.edited([source.above(first, f"    {_CHANCE} = {value}\n\n")])
    return source.edited([source.below(first, f"\n    {_CHANCE} = {value}\n")])


def _chance(task: TaskClass) -> ast.Assign | ast.AnnAssign | None:
    for node in task.node.body:
        targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
        if isinstance(node, ast.Assign | ast.AnnAssign) and [ast.unparse(target) for target in targets] == [_CHANCE]:
            return node
    return None


# Graspable objects ------------------------------------------------------------------------------------------------------------


def _read_graspable(task: TaskClass) -> tuple[str, ...] | None:
    """Return the names that a task registers; None when they are not literals in one call."""
    calls = task.calls(_GRASPABLE)
    if not calls:
        return ()
    items = _graspable_items(calls)
    names = [text_of(item) for item in items.elts] if items is not None else [None]
    return None if None in names else tuple(name for name in names if name is not None)


def _with_graspable(task: TaskClass, names: Sequence[str]) -> str | None:
    source, calls, indent = task.source, task.calls(_GRASPABLE), task.init_indent
    texts = [quoted(name) for name in names]
    if not calls:
        call = laid_out(f"self.{_GRASPABLE}([{', '.join(texts)}])", indent, len(indent))
        return source.edited([task.into_init(f"{indent}{call}\n")])
    items = _graspable_items(calls)
    if items is None:
        return None
    statement = next((s for s in task.init.body if isinstance(s, ast.Expr) and s.value is calls[0]), None)
    if not texts and statement is not None:
        return source.edited([source.without(statement)])
    return source.edited(source.new_list(items, texts))


def _graspable_items(calls: list[ast.Call]) -> ListNode | None:
    argument = calls[0].args[0] if len(calls) == 1 and len(calls[0].args) == 1 else None
    return argument if isinstance(argument, ListNode) else None


# Sentences --------------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Said:
    """The statement that returns the instructions, their lists, and the table that contains them, if any."""

    answer: ast.Return
    groups: list[ListNode]
    table: Binding | None


def _read_sentences(task: TaskClass) -> Sentences | None:
    """Return the instructions; None if they are not literals."""
    said = _said(task)
    if said is None:
        return None
    groups = tuple(tuple(_sentence(task.source, item) for item in group.elts) for group in said.groups)
    return None if any(None in group for group in groups) else groups  # type: ignore[return-value]


def takes_sentences_of_scene(text: str) -> bool:
    """Whether the Python returns the sentences of `[instructions]` in the scene file."""
    source = source_or_none(text)
    task = TaskClass.of(source) if source is not None else None
    method = task.method("init_episode") if task is not None else None
    answer = only_return(method) if method is not None else None
    call = answer.value if answer is not None else None
    return isinstance(call, ast.Call) and ast.unparse(call.func) == "self.make_instructions"


def _with_sentences(task: TaskClass, new: Sentences) -> str | None:
    """Return the Python with other instructions and their number of variations; None when it cannot express them."""
    said, source = _said(task), task.source
    if said is None:
        return None
    groups = _texts(source, said, new)
    if len(new) == (1 if said.table is None else len(said.groups)):
        changes = [change for node, group in zip(said.groups, groups, strict=True) for change in source.new_list(node, group)]
        text: str | None = source.edited(changes)
    else:
        text = _in_one_list(task, said, groups[0]) if len(new) == 1 else _in_table(task, said, groups)
    changed = TaskClass.of(Source(text)) if text is not None else None
    if changed is None or len(new) == 1 or _read_count(changed) in (None, len(new)):
        return text
    return _with_count(changed, len(new))


def _in_one_list(task: TaskClass, said: _Said, group: Sequence[str]) -> str:
    """Return one list for all variations instead of a table."""
    source = task.source
    indent = " " * said.answer.col_offset
    found: list[Replacement] = [(*source.span(said.answer), f"return {listed(group, indent, len(f'{indent}return '))}")]
    body = source.tree.body
    if said.table is not None and said.table.is_alone and said.table.statement in body:
        number = body.index(said.table.statement)
        words = body[number + 1] if number + 1 < len(body) else None  # the docstring of the table
        last = words if isinstance(words, ast.Expr) and text_of(words.value) is not None else said.table.statement
        start, end = source.line_span(said.table.statement)[0], source.line_span(last)[1]
        gap = len(source.text[end:]) - len(source.text[end:].lstrip("\n"))
        above_is_import = number > 0 and isinstance(body[number - 1], ast.Import | ast.ImportFrom)
        found.append((start, end + gap, "\n" if gap >= 2 and above_is_import else ""))
    return source.edited(found)


def _in_table(task: TaskClass, said: _Said, groups: Sequence[Sequence[str]]) -> str | None:
    """Return a table with a list for each variation, which the `return` statement indexes."""
    source, body = task.source, task.source.tree.body
    if said.table is not None:
        indent = " " * said.table.statement.col_offset
        return source.edited([(*source.span(said.table.value), _table(groups, indent))])
    if any(text.startswith("f") for group in groups for text in group):
        return None
    start, _ = source.line_span(task.node)
    above = body[body.index(task.node) - 1]
    gap = source.line_span(above)[1] if isinstance(above, ast.Import | ast.ImportFrom) else start
    table = f"{_TABLE} = {_table(groups, '')}\n{_TABLE_WORDS}\n\n\n"
    answer = f"return {_TABLE}[{_variation(task)}]"
    return source.edited([(gap, start, f"\n{table}" if gap < start else table), (*source.span(said.answer), answer)])


def _table(groups: Sequence[Sequence[str]], indent: str) -> str:
    deeper = indent + INDENT
    return "(\n" + "".join(f"{deeper}{listed(group, deeper, len(deeper), 1)},\n" for group in groups) + f"{indent})"


def _said(task: TaskClass) -> _Said | None:
    method = task.method("init_episode")
    answer = only_return(method) if method is not None else None
    if answer is None:
        return None
    value = answer.value
    if isinstance(value, ast.List):
        return _Said(answer, [value], None)
    if not isinstance(value, ast.Subscript) or ast.unparse(value.slice) != _variation(task):
        return None
    table = task.bindings(method).get(ast.unparse(value.value))
    groups = _groups(table.value) if table is not None else []
    return _Said(answer, groups, table) if len(groups) >= 2 else None


def _groups(node: ast.expr) -> list[ListNode]:
    """Return the lists of a table (list, tuple or dict) with one for each variation; empty if it is not such a table."""
    items: Sequence[ast.expr] = node.elts if isinstance(node, ListNode) else ()
    if isinstance(node, ast.Dict):
        keys = [key.value if isinstance(key, ast.Constant) else None for key in node.keys]
        items = node.values if keys == list(range(len(keys))) else ()
    found = [item for item in items if isinstance(item, ListNode)]
    return found if len(found) == len(items) else []


def _variation(task: TaskClass) -> str:
    """Return the name of the parameter of `init_episode` that is the variation."""
    method = task.method("init_episode")
    names = [argument.arg for argument in method.args.args] if method is not None else []
    return names[1] if len(names) > 1 else "variation"


def _sentence(source: Source, node: ast.expr) -> str | None:
    """Return the text of a sentence; `{...}` in an f-string stays as it is written."""
    if not isinstance(node, ast.JoinedStr):
        return text_of(node)
    found = _PLAIN_F_STRING.fullmatch(source.part(node))
    plain = _ESCAPED_QUOTE.sub(r"\1", found[2]) if found is not None else "\\"
    return None if "\\" in plain else plain


def _texts(source: Source, said: _Said, groups: Sentences) -> list[list[str]]:
    """Return sentences as Python: those that exist keep their text, those with only fields of others are f-strings."""
    items = [item for group in said.groups for item in group.elts]
    known = {_sentence(source, item): source.part(item) for item in items}
    parts = [part for item in items if isinstance(item, ast.JoinedStr) for part in item.values]
    fields = {ast.unparse(part.value) for part in parts if isinstance(part, ast.FormattedValue)}

    def written(sentence: str) -> str:
        own = [found.partition(":")[0].partition("!")[0] for found in _FIELD.findall(sentence)]
        is_f_string = bool(own) and set(own) <= fields and not {'"', "'"} & set("".join(own))
        return f"f{quoted(sentence)}" if is_f_string else quoted(sentence)

    return [[known.get(sentence) or written(sentence) for sentence in group] for group in groups]


# Names in the Python ----------------------------------------------------------------------------------------------------------


def _without_idle_names(old: Source, new: Source) -> Source:
    """Remove assignments of elements and conditions that were used before an edit and are not any more."""
    used_before = _used(old)
    while True:
        idle = used_before - _used(new)
        assignments = [
            node
            for function in ast.walk(new.tree)
            if isinstance(function, Function)
            for node in function.body
            if isinstance(node, ast.Assign) and len(node.targets) == 1 and _is_element_or_condition(node.value)
        ]
        gone = [statement for statement in assignments if ast.unparse(statement.targets[0]) in idle]
        if not gone:
            return new
        new = Source(new.edited(new.without(statement) for statement in gone))


def _is_element_or_condition(value: ast.expr) -> bool:
    is_condition = isinstance(value, ast.Call) and isinstance(value.func, ast.Name) and kind_of(value.func.id) is not None
    return is_condition or named_element(value) is not None


def _used(source: Source) -> set[str]:
    return {
        ast.unparse(node)
        for node in ast.walk(source.tree)
        if isinstance(node, ast.Name | ast.Attribute) and isinstance(node.ctx, ast.Load)
    }


def _with_shared_lookups(old: Source, new: Source) -> Source:
    """Look up an element only once, as an attribute, if an edit has made a form name it once more."""
    task, before = TaskClass.of(new), TaskClass.of(old)
    if task is None or before is None or not body_of(task.init):
        return new
    places, known = _lookups_of_forms(task), Counter(element for element, _ in _lookups_of_forms(before))
    counts = Counter(element for element, _ in places)
    chosen = [element for element, n in counts.items() if n > max(1, known[element]) and _is_free(task, element.name)]
    if not chosen:
        return new
    lines = "".join(f"{task.init_indent}self.{element.name} = {expression(element, {})}\n" for element in chosen)
    found = [(*new.span(node), f"self.{element.name}") for element, node in places if element in chosen]
    new = Source(new.edited([new.above(body_of(task.init)[0], lines), *found]))
    found, task = [], TaskClass.of(new)
    for call in [*task.calls(SUCCESS), *task.calls(FAILURE)] if task is not None else []:
        start, end = new.span(call)
        indent = new.indent_before(start)
        if not indent.strip() and "#" not in new.part(call):  # perhaps short enough for one line now
            found.append((start, end, laid_out(one_line(new.part(call)), indent, len(indent))))
    return Source(new.edited(found))


def _lookups_of_forms(task: TaskClass) -> list[tuple[Named, ast.Call]]:
    """Return the look-ups of elements in conditions and in random placements."""
    calls = [node for node in ast.walk(task.node) if isinstance(node, ast.Call)]
    outer = [*task.calls(SUCCESS), *task.calls(FAILURE)]
    outer += [node for node in calls if isinstance(node.func, ast.Attribute) and node.func.attr == "sample"]
    inner = [node for call in outer for node in ast.walk(call) if isinstance(node, ast.Call)]
    found = [(named_element(node), node) for node in inner]
    return [(element, node) for element, node in found if element is not None and element.kind != "joint"]


def _is_free(task: TaskClass, name: str) -> bool:
    """Whether a task has no attribute of that name."""
    own = {node.attr for node in ast.walk(task.node) if isinstance(node, ast.Attribute)}
    own |= {node.name for node in ast.walk(task.node) if isinstance(node, ast.FunctionDef)}
    own |= {node.id for node in ast.walk(task.node) if isinstance(node, ast.Name)}
    return name not in own | _TAKEN and not hasattr(Task, name) and not iskeyword(name)


# Fields -----------------------------------------------------------------------------------------------------------------------

_FIELDS: Mapping[str, tuple[Callable[[TaskClass], Any], Callable[[TaskClass, Any], str | None]]] = {
    "title": (
        lambda task: ast.get_docstring(task.source.tree),
        lambda task, text: _with_docstring(task.source, task.source.tree, text),
    ),
    "description": (
        lambda task: ast.get_docstring(task.node),
        lambda task, text: _with_docstring(task.source, task.node, text),
    ),
    "instructions": (_read_sentences, _with_sentences),
    "variation_count": (_read_count, _with_count),
    "solved_by_chance": (_read_chance, _with_chance),
    "graspable": (_read_graspable, _with_graspable),
    "success": (lambda task: read_conditions(task, SUCCESS), lambda task, forms: with_conditions(task, SUCCESS, forms)),
    "failure": (lambda task: read_conditions(task, FAILURE), lambda task, forms: with_conditions(task, FAILURE, forms)),
    "placements": (read_placements, with_placements),
}
"""Field -> how it is read and written; None where it is not written in a form that can be edited."""


@dataclass(frozen=True)
class Behaviour:
    """The values that forms show of the Python; a field is None where it is not written in a form that can be edited.

    Attributes:
        title: Docstring of the file.
        description: Docstring of the class: what varies, and what counts as success.
        instructions: The instructions: one group for all variations, or one for each.
        variation_count: Number of variations.
        solved_by_chance: Whether random actions may sometimes reach the goal.
        graspable: Names of the bodies that the gripper may hold, `<body>/<link>` for one link alone.
        success: Conditions that must hold at the same instant.
        failure: Conditions that end an episode without success when all hold at the same instant.
        placements: Elements that are placed at random in regions.
        python: The text that this was read from.
    """

    title: str | None = None
    description: str | None = None
    instructions: Sentences | None = None
    variation_count: int | None = None
    solved_by_chance: bool | None = None
    graspable: tuple[str, ...] | None = None
    success: Conditions | None = None
    failure: Conditions | None = None
    placements: tuple[SpawnForm, ...] | None = None
    python: str = field(default="", repr=False, compare=False)

    @classmethod
    def of(cls, text: str) -> Behaviour:
        """Read a Python file; all fields are None where it is not valid, or has no task."""
        source = source_or_none(text)
        if source is None:
            return cls(python=text)
        task = TaskClass.of(source)
        if task is None:
            return cls(title=ast.get_docstring(source.tree), python=text)
        return cls(**{name: read(task) for name, (read, _) in _FIELDS.items()}, python=text)

    def written(self, name: str, value: Any) -> str:
        """Return the Python in which a field has another value; the same text when it has it already.

        Raises:
            EditRefused: No form can edit this part of the Python.
            InvalidValue: The value is not of the kind of the field.
        """
        as_choice(name, "field", tuple(_FIELDS))
        wanted = _checked(name, value)
        if getattr(self, name) is None:
            raise EditRefused(f"change {name}", "no form can edit this part of the Python.", "Edit the text in *Files*.")
        if getattr(self, name) == wanted:
            return self.python
        old = Source(self.python)
        task = TaskClass.of(old)
        text = _with_docstring(old, old.tree, wanted) if task is None else _FIELDS[name][1](task, wanted)
        if text is None:
            raise EditRefused(f"change {name}", "no form can write this value to the Python.", "Edit the text in *Files*.")
        try:
            new = _without_idle_names(old, Source(text))
            new = _with_shared_lookups(old, new)
            return Source(with_imports(old, new)).text
        except PythonSyntaxError as error:
            raise EditRefused(f"change {name}", f"the result is not valid Python: {error}.", "Edit the text.") from error


def _checked(name: str, value: Any) -> Any:
    """Return a value as a field has it."""
    match name:
        case "title" | "description":
            return as_text(value, name).strip()
        case "variation_count":
            return as_whole(value, name, least=1)
        case "solved_by_chance":
            return as_flag(value, name)
        case "graspable":
            return tuple(as_names(value, name))
        case "instructions":
            groups = as_several(value, name)
            if not groups:
                raise InvalidValue(name, value, "has to have at least one group of instructions")
            return tuple(tuple(as_text(sentence, "sentence") for sentence in as_several(group, name)) for group in groups)
        case "placements":
            return tuple(as_record(item, SpawnForm, f"entry {k} of {name}") for k, item in enumerate(as_several(value, name)))
    forms = as_several(value, name)
    for number, item in enumerate(forms):
        if not isinstance(item, Written):
            check_form(as_record(item, ConditionForm, f"entry {number} of {name}"))
    return forms


def without_names(python: str, names: Collection[str]) -> str:
    """Return the Python without these elements of the scene in its forms; parts that no form can edit do not change."""
    for name in _NAMING:
        behaviour = Behaviour.of(python)
        parts = getattr(behaviour, name)
        kept = tuple(part for part in (_without(part, names) for part in parts or ()) if part is not None)
        if parts is None or kept == parts:
            continue
        try:
            python = behaviour.written(name, kept)
        except EditRefused:
            continue
    return python


def _without(part: Any, names: Collection[str]) -> Any:
    """Return a part of a field without its references to elements; None where nothing is left."""
    if isinstance(part, SpawnForm):
        elements = tuple(spawned for spawned in part.elements if not _is_about(spawned.element, names))
        regions = tuple(region for region in part.regions if region not in names)
        return replace(part, regions=regions, elements=elements) if regions and (elements or not part.elements) else None
    return None if _is_about(part, names) else part


def _is_about(part: object, names: Collection[str]) -> bool:
    """Whether a name, or a condition with all its arguments, names one of the elements."""
    if isinstance(part, Named):
        return part.name in names or part.name.partition("/")[0] in names
    if isinstance(part, ConditionForm):
        return _is_about(part.arguments, names)
    if isinstance(part, Mapping | tuple):
        return any(_is_about(value, names) for value in (part.values() if isinstance(part, Mapping) else part))
    return isinstance(part, str) and part.partition("/")[0] in names
