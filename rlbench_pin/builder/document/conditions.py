"""Conditions in the Python of a task: read them for forms, and change the lists that a task registers."""

from __future__ import annotations

import ast
import inspect
import math
import operator
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Literal

from rlbench_pin.builder.document.python_text import (
    LOOKUPS,
    Binding,
    ListNode,
    Source,
    TaskClass,
    is_own,
    laid_out,
    one_line,
    quoted,
    text_of,
)
from rlbench_pin.builder.document.texts import Replacement, replaced
from rlbench_pin.errors import InvalidValue, UnknownName
from rlbench_pin.tasks import conditions
from rlbench_pin.tasks.conditions import Condition

# Records ----------------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Named:
    """An element of the scene, `self.world.<kind>("<name>")`."""

    kind: Literal["body", "joint", "frame", "region", "sensor"]
    name: str


@dataclass(frozen=True)
class Written:
    """The text of an expression that no form can show."""

    text: str


@dataclass(frozen=True)
class ConditionForm:
    """A condition.

    Attributes:
        kind: Its class, such as `Detected`.
        arguments: Name of a parameter -> value, without robot and gripper, and without those at their default.
    """

    kind: str
    arguments: Mapping[str, Argument] = field(default_factory=dict)


Argument = Named | Written | ConditionForm | tuple["Argument", ...] | float | int | bool | str | None
"""An argument of a condition."""
ParameterKind = Literal[
    "body", "place", "joint", "frame", "sensor", "number", "whole", "flag", "numbers", "points", "conditions", "places"
]
"""Kind of an argument; a place is a body or a frame, points are lists of three coordinates."""


@dataclass(frozen=True)
class Parameter:
    """A parameter of a condition, with its description and its default."""

    name: str
    kind: ParameterKind
    text: str
    required: bool
    default: object = None


@dataclass(frozen=True)
class ConditionKind:
    """A class of conditions that a form can make: when it holds, and its parameters without robot and gripper."""

    name: str
    text: str
    parameters: tuple[Parameter, ...]


# Kinds of conditions ----------------------------------------------------------------------------------------------------------

_AUTOMATIC: Mapping[str, str] = {"SimRobot": "self.robot", "SimGripper": "self.gripper"}
"""Type of an argument that a task has itself -> its expression."""
_KINDS: Mapping[str, ParameterKind] = {
    "Body": "body",
    "Body | Frame": "place",
    "ObjectJoint": "joint",
    "Frame": "frame",
    "Sensor": "sensor",
    "float": "number",
    "int": "whole",
    "bool": "flag",
    "Sequence[float]": "numbers",
    "Sequence[Sequence[float]] | FloatArray": "points",
    "Sequence[Condition]": "conditions",
    "Sequence[Body | Frame]": "places",
}
"""Type of an argument -> its kind."""
_ARGUMENT = re.compile(r"^    (?=\w+:)", re.MULTILINE)
"""Start of the description of an argument in a docstring."""


@cache
def condition_kinds() -> tuple[ConditionKind, ...]:
    """Return every condition whose arguments a form can ask for, by name."""
    found = (_condition_kind(getattr(conditions, name)) for name in sorted(conditions.__all__))
    return tuple(kind for kind in found if kind is not None)


def kind_of(name: str) -> ConditionKind | None:
    """Return the condition of that name, None when no form can make it."""
    return next((kind for kind in condition_kinds() if kind.name == name), None)


def check_form(form: ConditionForm) -> None:
    """Raise UnknownName or InvalidValue unless a condition can be made of a form, and of those within it."""
    kind = kind_of(form.kind)
    if kind is None:
        raise UnknownName("condition that forms can make", form.kind, [kind.name for kind in condition_kinds()])
    known = [parameter.name for parameter in kind.parameters]
    for name, value in form.arguments.items():
        if name not in known:
            raise UnknownName(f"argument of {form.kind}", name, known)
        for part in value if isinstance(value, tuple | list) else (value,):
            if isinstance(part, ConditionForm):
                check_form(part)
    for parameter in kind.parameters:
        if parameter.required and parameter.name not in form.arguments:
            raise InvalidValue(f"{parameter.name} of {form.kind}", None, "has to be given", parameter.text)


@cache
def _automatic_arguments(kind: str) -> Mapping[str, str]:
    """Return all arguments of a condition, in order: name -> `self.robot` or `self.gripper`, empty for those of a form."""
    parameters = inspect.signature(getattr(conditions, kind)).parameters
    return {name: _AUTOMATIC.get(str(parameter.annotation), "") for name, parameter in parameters.items()}


@cache
def _defaults(kind: str) -> Mapping[str, object]:
    found = kind_of(kind)
    return {p.name: p.default for p in found.parameters if not p.required} if found is not None else {}


def _condition_kind(cls: type[Condition]) -> ConditionKind | None:
    if inspect.isabstract(cls):
        return None
    texts: dict[str, str] = {}
    for base in reversed(cls.__mro__):  # a class says more than its base
        _, _, said = inspect.cleandoc(base.__doc__ or "").partition("\nArgs:\n")
        for part in _ARGUMENT.split(said)[1:]:
            name, _, text = part.partition(":")
            texts[name] = " ".join(text.split())
    parameters = []
    for name, parameter in inspect.signature(cls).parameters.items():
        annotation = str(parameter.annotation)
        if annotation in _AUTOMATIC:
            continue
        kind = _KINDS.get(annotation.removesuffix(" | None"))
        if kind is None:
            return None
        required = parameter.default is inspect.Parameter.empty
        parameters.append(Parameter(name, kind, texts.get(name, ""), required, None if required else parameter.default))
    summary = (inspect.getdoc(cls) or "").partition("\n\n")[0]
    return ConditionKind(cls.__name__, " ".join(summary.split()), tuple(parameters))


# Expressions as forms ---------------------------------------------------------------------------------------------------------

_MAX_DEPTH = 12
"""Longest chain of names that are assigned to each other."""
_RADIANS = ("np.deg2rad", "np.radians", "math.radians")
_NUMBERS: Mapping[str, float] = {"np.pi": math.pi, "math.pi": math.pi}
_OPERATORS: Mapping[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
_DIGITS, _NEAR = 6, 1e-6


class Reader:
    """Reads expressions of one method, in which names have the values of `bindings`."""

    def __init__(self, source: Source, bindings: Mapping[str, Binding]) -> None:
        self.source, self.bindings = source, bindings

    def read(self, node: ast.expr, depth: int = 0) -> Argument:
        """Return an expression as a form has it, `Written` where none can show it."""
        number = self._number(node)
        if number is not None:
            return number
        if isinstance(node, ast.Constant) and (node.value is None or isinstance(node.value, bool | str)):
            return node.value
        if (named := named_element(node)) is not None:
            return named
        if isinstance(node, ast.List | ast.Tuple) and not any(isinstance(item, ast.Starred) for item in node.elts):
            return tuple(self.read(item, depth + 1) for item in node.elts)
        if isinstance(node, ast.Call) and (form := self._condition(node, depth)) is not None:
            return form
        bound = self.bindings.get(ast.unparse(node)) if isinstance(node, ast.Name | ast.Attribute) else None
        if bound is not None and depth < _MAX_DEPTH:
            found = self.read(bound.value, depth + 1)
            if not _is_computed(found):
                return found
        return Written(self.source.part(node))

    def arguments(self, node: ast.Call, kind: str) -> dict[str, ast.expr] | None:
        """Return the arguments of a condition by name; None when they are not plain."""
        names = list(_automatic_arguments(kind))
        if len(node.args) > len(names) or any(isinstance(item, ast.Starred) for item in node.args):
            return None
        found = dict(zip(names, node.args, strict=False))
        for keyword in node.keywords:
            if keyword.arg not in names or keyword.arg in found:
                return None
            found[keyword.arg] = keyword.value
        return found

    def elements_above(self, line: float = math.inf) -> dict[Named, str]:
        """Return the elements of the scene that have names in the Python above a line, preferably attributes of `self`."""
        bound = sorted(self.bindings.items(), key=lambda item: item[0].startswith("self."))
        found = ((named_element(binding.value), name) for name, binding in bound if binding.statement.lineno < line)
        return {element: name for element, name in found if element is not None}

    def _number(self, node: ast.expr, depth: int = 0) -> float | int | None:
        """Return the value of an expression of literal numbers and names for them, None for any other."""
        if isinstance(node, ast.Constant) and type(node.value) in (int, float):
            return node.value  # type: ignore[return-value]
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            inner = self._number(node.operand, depth)
            return None if inner is None else -inner
        if isinstance(node, ast.BinOp) and type(node.op) in _OPERATORS:
            left, right = self._number(node.left, depth), self._number(node.right, depth)
            if left is None or right is None or (isinstance(node.op, ast.Div) and right == 0):
                return None
            return _OPERATORS[type(node.op)](left, right)
        if isinstance(node, ast.Call) and ast.unparse(node.func) in _RADIANS and len(node.args) == 1 and not node.keywords:
            inner = self._number(node.args[0], depth)
            return None if inner is None else math.radians(inner)
        if isinstance(node, ast.Name | ast.Attribute):
            name = ast.unparse(node)
            bound = self.bindings.get(name)
            return _NUMBERS.get(name) if bound is None or depth > _MAX_DEPTH else self._number(bound.value, depth + 1)
        return None

    def _condition(self, node: ast.Call, depth: int) -> ConditionForm | None:
        kind = node.func.id if isinstance(node.func, ast.Name) and kind_of(node.func.id) is not None else None
        given = self.arguments(node, kind) if kind is not None else None
        if kind is None or given is None:
            return None
        own, defaults = _automatic_arguments(kind), _defaults(kind)
        if any(own[name] and ast.unparse(value) != own[name] for name, value in given.items()):
            return None
        read = {name: self.read(value, depth + 1) for name, value in given.items() if not own[name]}
        return ConditionForm(kind, {n: v for n, v in read.items() if n not in defaults or defaults[n] != v})


def named_element(node: ast.expr) -> Named | None:
    """Return the element that `self.world.<kind>("<name>")` looks up, None for any other expression."""
    if not isinstance(node, ast.Call) or len(node.args) != 1 or node.keywords or not isinstance(node.func, ast.Attribute):
        return None
    name = text_of(node.args[0])
    if name is None or node.func.attr not in LOOKUPS or not is_own(node.func.value, "world"):
        return None
    return Named(node.func.attr, name)  # type: ignore[arg-type]


def _is_computed(value: Argument) -> bool:
    return isinstance(value, Written) or (isinstance(value, tuple) and any(_is_computed(item) for item in value))


# Forms as expressions ---------------------------------------------------------------------------------------------------------


def expression(value: Argument, names: Mapping[Named, str]) -> str:
    """Return the Python of a value; `names` are those that elements of the scene have in the Python already."""
    if isinstance(value, Written):
        return value.text
    if isinstance(value, Named):
        return names.get(value, f"self.world.{value.kind}({quoted(value.name)})")
    if isinstance(value, ConditionForm):
        return _call(value, names)
    if isinstance(value, tuple | list):
        return list_expression(value, names)
    if isinstance(value, str):
        return quoted(value)
    return number_text(value) if isinstance(value, float) else repr(value)


def list_expression(values: Iterable[Argument], names: Mapping[Named, str]) -> str:
    return f"[{', '.join(expression(value, names) for value in values)}]"


def number_text(value: float, before: str = "") -> str:
    """Return a number as Python, in degrees where it was written so before."""
    call = next((call for call in _RADIANS if before.startswith(f"{call}(")), None)
    degrees = round(math.degrees(value), 2) + 0.0
    if call is not None and abs(math.radians(degrees) - value) < _NEAR:
        return f"{call}({degrees})"
    return repr(round(float(value), _DIGITS) + 0.0)


def _call(form: ConditionForm, names: Mapping[Named, str]) -> str:
    parts, is_open, defaults = [], True, _defaults(form.kind)
    for name, own in _automatic_arguments(form.kind).items():
        if own:
            parts.append(own)
        elif name not in form.arguments or (name in defaults and form.arguments[name] == defaults[name]):
            is_open = False
        else:
            text = expression(form.arguments[name], names)
            parts.append(text if is_open and name not in defaults else f"{name}={text}")
    return f"{form.kind}({', '.join(parts)})"


# Lists of conditions ---------------------------------------------------------------------------------------------------------

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
        names = Reader(source, task.bindings(task.init)).elements_above()
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
    """Return the replacements for other items of the list; changed lines of the call are formatted again."""
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
    """Return the assignment of a name, also through other names."""
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
