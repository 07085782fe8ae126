"""The table of errors: cause, message and next step of every error type."""

from __future__ import annotations

import ast
import importlib
import inspect
import pkgutil
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping

from docs_lib.public import OPTIONAL_LIBRARIES, PACKAGE, public_names
from reference_lib.docs import doc_of, table
from sphinx.ext.autodoc.mock import mock

import rlbench_pin
from rlbench_pin.errors import MissingExtra, RlbenchPinError

MOST = 3
"""Messages that are shown of one type."""
HEAD = """# Errors

Every error that the package raises on purpose derives from `rlbench_pin.errors.RlbenchPinError`. Its message names the object, the
value, what is possible and the next step; the same facts are attributes of the error. *Italic* words in the messages below
stand for values. A name with a link is public and can be imported.

"""


def error_page() -> dict[str, str]:
    """Return file -> text of the page of all error types."""
    messages = all_messages()
    homes = {name: module for module, names in sorted(public_names().items(), reverse=True) for name in names}
    rows = [row(kind, messages, homes) for kind in sorted(error_types(), key=lambda kind: kind.__name__.lower())]
    return {"errors.md": f"{HEAD}:::{{table}}\n:class: errors\n\n{table(('Error', 'Cause', 'Message', 'Next step'), rows)}\n:::\n"}


def error_types() -> list[type[RlbenchPinError]]:
    """Return all types, in all modules that programs use."""
    with mock(list(OPTIONAL_LIBRARIES)):
        for module in pkgutil.walk_packages(rlbench_pin.__path__, "rlbench_pin."):
            if not module.name.startswith(("rlbench_pin.compat", "rlbench_pin.cli")):
                try:
                    importlib.import_module(module.name)
                except MissingExtra:
                    continue
    found = list(dict.fromkeys(derived(RlbenchPinError)))
    return [kind for kind in found if kind.__module__.startswith("rlbench_pin.") and not kind.__module__.startswith("rlbench_pin.compat")]


def derived(kind: type[RlbenchPinError]) -> Iterator[type[RlbenchPinError]]:
    """Yield the types derived from a type."""
    for each in kind.__subclasses__():
        yield each
        yield from derived(each)


def row(kind: type[RlbenchPinError], messages: Mapping[str, list[str]], homes: Mapping[str, str]) -> tuple[str, ...]:
    """Return the row of a type."""
    name = kind.__name__
    shown = f"{{py:obj}}`~{homes[name]}.{name}`" if name in homes else f"`{name}`"
    split = [parted(message) for message in messages_of(kind, messages)]
    told = list(dict.fromkeys(problem for problem, _ in split))
    advice = list(dict.fromkeys(step for _, step in split if step))
    return shown, doc_of(kind).first, "<br>".join(told[:MOST]), "<br>".join(advice[:MOST]) or next_step(kind, messages)


def messages_of(kind: type[RlbenchPinError], messages: Mapping[str, list[str]]) -> list[str]:
    """Return the messages of a type: the one that it makes itself, or those with which it is raised."""
    return messages.get(f"class {kind.__name__}") or messages.get(kind.__name__, [])


def next_step(kind: type[RlbenchPinError], messages: Mapping[str, list[str]]) -> str:
    """Return the advice of the nearest base that has some."""
    for base in kind.__mro__[1:]:
        if issubclass(base, RlbenchPinError):
            for _, step in map(parted, messages_of(base, messages)):
                if step:
                    return step
    return ""


def parted(message: str) -> tuple[str, str]:
    """Return the sentence that says what is wrong, and what follows it."""
    problem, _, step = message.partition(". ")
    return (f"{problem}." if step else problem), step


# Messages in the source ---------------------------------------------------------------------------------------------------------


def all_messages() -> dict[str, list[str]]:
    """Return type -> the messages with which it is raised; `class TYPE` -> the message that it makes itself."""
    found: dict[str, list[str]] = defaultdict(list)
    for file in sorted(PACKAGE.rglob("*.py")):
        tree = ast.parse(file.read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call) and isinstance(node.exc.func, ast.Name):
                found[node.exc.func.id] += [text for text in map(text_of, node.exc.args) if " " in text.strip()][:1]
            elif isinstance(node, ast.ClassDef):
                found[f"class {node.name}"] += own_message(node)
    return found


def own_message(kind: ast.ClassDef) -> list[str]:
    """Return the text that a class hands to `Exception`, if its first argument is one."""
    for node in ast.walk(kind):
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "super().__init__" and node.args:
            text = text_of(node.args[0])
            return [text] if " " in text.strip() else []
    return []


def text_of(node: ast.expr) -> str:
    """Return a text as Markdown, with what is filled in in italics; "" where it is none."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return escaped(node.value)
    if isinstance(node, ast.JoinedStr):
        return "".join(text_of(part) if isinstance(part, ast.Constant) else value(part) for part in node.values)
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        return text_of(node.left) + text_of(node.right)
    return ""


def value(node: ast.expr) -> str:
    """Return the name of what is filled in."""
    words = re.findall(r"[a-z_]\w*", ast.unparse(node.value)) if isinstance(node, ast.FormattedValue) else []
    words = [word for word in words if word not in ("self", "str", "len", "join", "shown", "for", "in", "if", "else", "not", "sorted")]
    return f"*{words[-1] if words else 'value'}*".replace("_", " ")


def escaped(text: str) -> str:
    """Return a text for a cell of a table."""
    return re.sub(r"([*<>\[\]])", r"\\\1", " ".join(text.split(" "))).replace("\n", " ")
