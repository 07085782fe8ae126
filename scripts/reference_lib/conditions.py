"""The page about conditions and about what a task file may override and call."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Sequence
from types import FunctionType

import rlbench_pin.tasks as front_door
from reference_lib.docs import arguments_of, attribute_docs, doc_of, shown, signature, table
from rlbench_pin.tasks import Condition, Task, Waypoint, conditions

_HEADING = re.compile(r"^    # (.+?) -{3,}$", re.MULTILINE)
_METHOD = re.compile(r"^    (?:@\w+\n    )?def ([a-z]\w*)\(", re.MULTILINE)
OVERRIDDEN, CALLED, BY_ENVIRONMENT = "What a task file overrides", "What a task file calls", "What the environment calls"
TOOLS = (
    "SpawnBoundary", "clearance", "settle", "at_rest", "easiest_top_grasp", "Tray", "free_direction", "swap_places",
    "distractor_colors", "fill_up_colors",
)  # fmt: skip
"""What several tasks need, from `rlbench_pin.tasks`."""


def parts() -> dict[str, str]:
    """Return what the page has generated, by marker."""
    sections = methods()
    return {
        "conditions": "\n\n".join(_condition(getattr(conditions, name)) for name in condition_names()),
        "base": _methods([getattr(Condition, name) for name in ("met", "reset", "state", "set_state")]),
        "overridden": _methods(sections[OVERRIDDEN]) + "\n\n" + _attributes(Task),
        "called": _called(sections[CALLED]),
        "by-environment": _methods(sections[BY_ENVIRONMENT]),
        "waypoint": _waypoint(),
        "tools": _tools(),
    }


def condition_names() -> list[str]:
    """Return the names of the conditions, without the base class."""
    return [name for name in conditions.__all__ if name != "Condition"]


def methods() -> dict[str, list[FunctionType]]:
    """Return the public methods of `Task` by the heading that they stand below in its source."""
    found: dict[str, list[FunctionType]] = {}
    pieces = _HEADING.split(inspect.getsource(Task))
    for heading, source in zip(pieces[1::2], pieces[2::2], strict=True):
        names = [name for name in _METHOD.findall(source) if isinstance(inspect.getattr_static(Task, name), FunctionType)]
        found[heading] = [getattr(Task, name) for name in names]
    return found


def _condition(cls: type) -> str:
    doc, given = doc_of(cls), inspect.signature(cls).parameters.values()
    means = arguments_of(cls)
    rows = [(f"`{p.name}`", "" if p.default is p.empty else f"`{shown(p.default)}`", means[p.name]) for p in given]
    keeps = "" if cls.state is Condition.state else f"\n\nIt remembers: {_kept(cls.state)}"  # type: ignore[attr-defined]
    return f"### {cls.__name__}\n\n{doc.text}{keeps}\n\n{table(('Argument', 'Default', 'Meaning'), rows)}"


def _kept(state: Callable[..., object]) -> str:
    """Say what `state` returns."""
    return doc_of(state).first.removeprefix("Return ")


def _methods(functions: Sequence[Callable[..., object]]) -> str:
    rows = [(f"`{f.__name__}({signature(f)})`", doc_of(f).text.replace("\n\n", " ")) for f in functions]
    return table(("Method", "What it does"), rows)


def _attributes(cls: type) -> str:
    rows = [(f"`{name}`", f"`{getattr(cls, name)}`", text) for name, text in attribute_docs(cls).items()]
    return table(("Class attribute", "Default", "Meaning"), rows)


def _called(functions: Sequence[Callable[..., object]]) -> str:
    """Return the methods, then the attributes that come with every task."""
    rows = [(f"`self.{name}`", text) for name, text in doc_of(Task).sections["Attributes"].items()]
    return f"{_methods(functions)}\n\n{table(('Attribute', 'What it is'), rows)}"


def _waypoint() -> str:
    """Return the attributes and properties of waypoints that hooks read and write."""
    rows = [(f"`{name}`", text) for name, text in doc_of(Waypoint).sections["Attributes"].items()]
    rows += [(f"`{name}`", doc_of(value).first) for name, value in vars(Waypoint).items() if isinstance(value, property)]
    arguments = doc_of(Waypoint).sections["Args"]
    rows = [*((f"`{name}`", arguments[name]) for name in ("index", "frame", "spec")), *rows]
    return table(("Attribute", "What it is"), rows)


def _tools() -> str:
    rows = []
    for name in TOOLS:
        item = getattr(front_door, name)
        rows.append((f"`{name}({signature(item)})`", doc_of(item).first))
        inner = vars(item).items() if isinstance(item, type) else ()
        public = [(inside, value) for inside, value in inner if isinstance(value, FunctionType) and not inside.startswith("_")]
        rows += [(f"`{name}.{inside}({signature(value)})`", doc_of(value).first) for inside, value in public]
    return table(("Name", "What it is"), rows)
