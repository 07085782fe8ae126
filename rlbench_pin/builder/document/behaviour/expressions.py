"""Expressions of a task as forms see them, and forms as expressions."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping

from rlbench_pin.builder.document.behaviour.forms import Argument, ConditionForm, Named, Written
from rlbench_pin.builder.document.behaviour.kinds import arguments_of, kind_of
from rlbench_pin.builder.document.behaviour.mentions import LOOKUPS
from rlbench_pin.builder.document.behaviour.source import Source, text_of
from rlbench_pin.builder.document.behaviour.task_class import Binding, is_own

_DEEPEST = 12
_TURNED = ("np.deg2rad", "np.radians", "math.radians")
_NUMBERS: Mapping[str, float] = {"np.pi": math.pi, "math.pi": math.pi}
_OPERATORS: Mapping[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
_DIGITS = 6


class Reader:
    """Reads expressions of one method.

    Args:
        source: The Python.
        bindings: What names stand for there.
    """

    def __init__(self, source: Source, bindings: Mapping[str, Binding]) -> None:
        self.source, self.bindings = source, bindings

    def read(self, node: ast.expr, depth: int = 0) -> Argument:
        """Return what an expression is for a form; what none can show is `Written`."""
        number = self.number(node)
        if number is not None:
            return number
        if isinstance(node, ast.Constant) and (node.value is None or isinstance(node.value, bool | str)):
            return node.value
        if (named := named_thing(node)) is not None:
            return named
        if isinstance(node, ast.List | ast.Tuple) and not any(isinstance(item, ast.Starred) for item in node.elts):
            return tuple(self.read(item, depth + 1) for item in node.elts)
        if isinstance(node, ast.Call) and (form := self._condition(node, depth)) is not None:
            return form
        bound = self.bindings.get(ast.unparse(node)) if isinstance(node, ast.Name | ast.Attribute) else None
        if bound is not None and depth < _DEEPEST:
            found = self.read(bound.value, depth + 1)
            if not _is_hidden(found):
                return found
        return Written(self.source.part(node))

    def number(self, node: ast.expr, depth: int = 0) -> float | int | None:
        """Return the number that an expression is, None when it is none that is written out."""
        if isinstance(node, ast.Constant) and type(node.value) in (int, float):
            return node.value  # type: ignore[return-value]
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            inner = self.number(node.operand, depth)
            return None if inner is None else -inner
        if isinstance(node, ast.BinOp) and type(node.op) in _OPERATORS:
            left, right = self.number(node.left, depth), self.number(node.right, depth)
            if left is None or right is None or (isinstance(node.op, ast.Div) and right == 0):
                return None
            return _OPERATORS[type(node.op)](left, right)
        if isinstance(node, ast.Call) and ast.unparse(node.func) in _TURNED and len(node.args) == 1 and not node.keywords:
            inner = self.number(node.args[0], depth)
            return None if inner is None else math.radians(inner)
        if isinstance(node, ast.Name | ast.Attribute):
            name = ast.unparse(node)
            bound = self.bindings.get(name)
            return _NUMBERS.get(name) if bound is None or depth > _DEEPEST else self.number(bound.value, depth + 1)
        return None

    def arguments(self, node: ast.Call, kind: str) -> dict[str, ast.expr] | None:
        """Return the arguments of a condition by name; None when they are not plain."""
        names = list(arguments_of(kind))
        if len(node.args) > len(names) or any(isinstance(item, ast.Starred) for item in node.args):
            return None
        found = dict(zip(names, node.args, strict=False))
        for keyword in node.keywords:
            if keyword.arg not in names or keyword.arg in found:
                return None
            found[keyword.arg] = keyword.value
        return found

    def _condition(self, node: ast.Call, depth: int) -> ConditionForm | None:
        kind = kind_of(node.func.id) if isinstance(node.func, ast.Name) else None
        given = self.arguments(node, kind.name) if kind is not None else None
        if kind is None or given is None:
            return None
        own = arguments_of(kind.name)
        if any(own[name] and ast.unparse(value) != own[name] for name, value in given.items()):
            return None
        said = {name: self.read(value, depth + 1) for name, value in given.items() if not own[name]}
        defaults = {parameter.name: parameter.default for parameter in kind.parameters if not parameter.required}
        return ConditionForm(kind.name, {n: v for n, v in said.items() if n not in defaults or defaults[n] != v})


def named_thing(node: ast.expr) -> Named | None:
    """Return the thing that `self.world.<kind>("<name>")` is, None for any other expression."""
    if not isinstance(node, ast.Call) or len(node.args) != 1 or node.keywords or not isinstance(node.func, ast.Attribute):
        return None
    name = text_of(node.args[0])
    if name is None or node.func.attr not in LOOKUPS or not is_own(node.func.value, "world"):
        return None
    return Named(node.func.attr, name)  # type: ignore[arg-type]


def expression(value: Argument, names: Mapping[Named, str]) -> str:
    """Return the Python of a value.

    Args:
        value: What a form says.
        names: Things that have a name in the Python already.
    """
    if isinstance(value, Written):
        return value.text
    if isinstance(value, Named):
        return names.get(value, f"self.world.{value.kind}({quoted(value.name)})")
    if isinstance(value, ConditionForm):
        return _call(value, names)
    if isinstance(value, tuple | list):
        return f"[{', '.join(expression(item, names) for item in value)}]"
    if isinstance(value, str):
        return quoted(value)
    return number_text(value) if isinstance(value, float) else repr(value)


def number_text(value: float, before: str = "") -> str:
    """Return a number as Python, in degrees where it was written so before."""
    call = next((call for call in _TURNED if before.startswith(f"{call}(")), None)
    if call is not None:
        return f"{call}({round(math.degrees(value), 2) + 0.0})"
    return repr(round(float(value), _DIGITS) + 0.0)


def quoted(text: str) -> str:
    """Return a text as Python, in double quotes unless it has such."""
    if '"' in text and "'" not in text:
        return repr(text)
    inner = repr(text)[1:-1].replace("\\'", "'").replace('"', '\\"')
    return f'"{inner}"'


def _call(form: ConditionForm, names: Mapping[Named, str]) -> str:
    kind, parts, is_open = kind_of(form.kind), [], True
    defaults = {} if kind is None else {p.name: p.default for p in kind.parameters if not p.required}
    for name, own in arguments_of(form.kind).items():
        if own:
            parts.append(own)
        elif name not in form.arguments or (name in defaults and form.arguments[name] == defaults[name]):
            is_open = False
        else:
            text = expression(form.arguments[name], names)
            parts.append(text if is_open and name not in defaults else f"{name}={text}")
    return f"{form.kind}({', '.join(parts)})"


def _is_hidden(value: Argument) -> bool:
    """Whether a form would hide what a name stands for: something that is computed."""
    return isinstance(value, Written) or (isinstance(value, tuple) and any(_is_hidden(item) for item in value))
