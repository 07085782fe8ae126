"""The table of errors: cause, message and next step of every error type."""

from __future__ import annotations

import ast
import importlib
import pkgutil
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from reference_lib.docs import doc_of, table
from sphinx.ext.autodoc.mock import mock

import rlbench_pin
from docs_lib.public import OPTIONAL_LIBRARIES, PACKAGE, public_names
from rlbench_pin.errors import MissingExtra, RlbenchPinError

NO_NAMES = (
    "self",
    "str",
    "len",
    "join",
    "shown",
    "removesuffix",
    "for",
    "in",
    "if",
    "else",
    "not",
    "sorted",
    "e",
    "f",
    "repr",
    "is",
    "none",
)
MOST = 3
"""Messages that are shown of one type."""
HEAD = """# Errors

Every error that the package raises on purpose derives from `rlbench_pin.errors.RlbenchPinError`. Its message names the object,
the value, what is possible and the next step; the same facts are attributes of the error. *Italic* words in the messages below
stand for values. A name with a link is public and can be imported.

"""


def error_page() -> dict[str, str]:
    """Return file -> text of the page of all error types."""
    messages = all_messages()
    homes = {name: module for module, names in sorted(public_names().items(), reverse=True) for name in names}
    rows = [row(kind, messages, homes) for kind in sorted(error_types(), key=lambda kind: kind.__name__.lower())]
    return {
        "errors.md": f"{HEAD}:::{{table}}\n:class: errors\n\n{table(('Error', 'Cause', 'Message', 'Next step'), rows)}\n:::\n"
    }


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
    return [
        kind
        for kind in found
        if kind.__module__.startswith("rlbench_pin.") and not kind.__module__.startswith("rlbench_pin.compat")
    ]


def derived(kind: type[RlbenchPinError]) -> Iterator[type[RlbenchPinError]]:
    """Yield the types derived from a type."""
    for each in kind.__subclasses__():
        yield each
        yield from derived(each)


def row(kind: type[RlbenchPinError], messages: Mapping[str, list[Message]], homes: Mapping[str, str]) -> tuple[str, ...]:
    """Return the row of a type."""
    name = kind.__name__
    shown = f"{{py:obj}}`~{homes[name]}.{name}`" if name in homes else f"`{name}`"
    found = messages.get(f"class {name}") or messages.get(name, [])
    problems = list(dict.fromkeys(message.problem for message in found))
    steps = list(dict.fromkeys(message.step for message in found if message.step))
    return shown, doc_of(kind).first, "<br>".join(problems[:MOST]), "<br>".join(steps[:MOST]) or other_step(kind)


def other_step(kind: type[RlbenchPinError]) -> str:
    """Return where the next step is said, for types whose messages are made where they are raised."""
    derived_names = [f"`{each.__name__}`" for each in kind.__subclasses__()]
    return f"See {', '.join(derived_names)}." if derived_names else "The message says it."


# Messages in the source ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Message:
    """A text of an error."""

    problem: str
    step: str
    """Sentences that say what to do; "" where they are made elsewhere."""


def message_of(arguments: Sequence[ast.expr]) -> list[Message]:
    """Return the message in the arguments of an error: the first text, and the later sentences or the next text as the step."""
    texts = [text for text in map(text_of, arguments) if " " in text.strip()]
    if not texts:
        return []
    problem, _, step = texts[0].partition(". ")
    return [Message(f"{problem}." if step else problem, step or " ".join(texts[1:2]))]


def all_messages() -> dict[str, list[Message]]:
    """Return type -> the messages with which it is raised; `class TYPE` -> the message that it makes itself."""
    found: dict[str, list[Message]] = defaultdict(list)
    for file in sorted(PACKAGE.rglob("*.py")):
        tree = ast.parse(file.read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call) and isinstance(node.exc.func, ast.Name):
                found[node.exc.func.id] += message_of(node.exc.args)
            elif isinstance(node, ast.ClassDef):
                found[f"class {node.name}"] += own_message(node)
    return found


def own_message(kind: ast.ClassDef) -> list[Message]:
    """Return the message that a class hands to its base."""
    for node in ast.walk(kind):
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "super().__init__" and node.args:
            return message_of(node.args)
    return []


def text_of(node: ast.expr) -> str:
    """Return a text as Markdown, with what is filled in in italics; "" where it is none."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return escaped(node.value)
    if isinstance(node, ast.JoinedStr):
        parts = [text_of(part) if isinstance(part, ast.Constant) else value(part) for part in node.values]
        return "".join(parts).replace("**", "* *")
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        return text_of(node.left) + text_of(node.right)
    return ""


def value(node: ast.expr) -> str:
    """Return the name of what is filled in."""
    words = re.findall(r"\b[a-z]\w*", ast.unparse(node.value)) if isinstance(node, ast.FormattedValue) else []
    name = next((word for word in reversed(words) if word not in NO_NAMES), "value")
    return f"*{name.removeprefix('get_').replace('_', ' ').strip()}*"


def escaped(text: str) -> str:
    """Return a text for a cell of a table."""
    return re.sub(r"([*<>\[\]])", r"\\\1", " ".join(text.split(" "))).replace("\n", " ")
