"""Where the Python of a task names things of its scene: what it looks up, what is renamed with them, what is left to people."""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from rlbench_pin.builder.document.python_text.source import Source, text_of, texts_of

LOOKUPS = ("body", "joint", "frame", "region", "sensor")
"""`self.world.body(name)` and so on."""
_BY_NUMBER = frozenset(
    {
        "register_waypoint_ability_start",
        "register_waypoint_ability_end",
        "register_stop_at_waypoint",
        "get_waypoint",
    }
)
"""Calls whose first argument is the number of a waypoint."""
_WAYPOINT = re.compile(r"waypoint(\d+)")


@dataclass(frozen=True)
class Lookup:
    """A thing that the Python looks up by a name that is written out."""

    kind: str
    """`body`, `joint`, ...; `graspable` for what the hand may hold."""
    name: str
    """As it is written."""
    line: int
    """Where."""


def lookups(source: Source) -> tuple[Lookup, ...]:
    """Return what the Python looks up in the world by names that are written out."""
    found = []
    for node in ast.walk(source.tree):
        if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute) or not node.args:
            continue
        first = node.args[0]
        if node.func.attr in LOOKUPS and ast.unparse(node.func.value) in ("self.world", "world"):
            found += [Lookup(node.func.attr, name, first.lineno) for name in _texts([first])]
        if node.func.attr == "register_graspable_objects" and isinstance(first, ast.List | ast.Tuple):
            found += [Lookup("graspable", name, first.lineno) for name in _texts(first.elts)]
    return tuple(found)


def mentions(source: Source, name: str) -> tuple[str, ...]:
    """Return the lines of Python in which a thing is named: as a text, by a pattern such as `f"block{i}"`, by its number."""
    numbers = {node.lineno for node, waypoint in _numbers(source) if waypoint == name}
    lines = {node.lineno for node, text in texts_of(source.tree) if _is_name(text, name)}
    return tuple(_shown(source, line) for line in sorted(lines | numbers | set(_patterns(source, name))))


def computed_waypoints(source: Source) -> tuple[str, ...]:
    """Return the lines that mean a waypoint by a number or a name that is not written out, and so cannot be renamed."""
    found = set()
    for node in ast.walk(source.tree):
        if isinstance(node, ast.JoinedStr) and node.values and (text_of(node.values[0]) or "").startswith("waypoint"):
            found.add(node.lineno)
        if (place := _place_of_number(node)) is not None and _written_number(place) is None:
            found.add(place.lineno)
        if isinstance(node, ast.Compare) and any(_is_index(part) for part in (node.left, *node.comparators)):
            found.add(node.lineno)
    return tuple(_shown(source, line) for line in sorted(found))


def _is_index(node: ast.expr) -> bool:
    """Whether an expression is the number of a waypoint, such as `waypoint.index`."""
    return isinstance(node, ast.Attribute) and node.attr == "index"


def renamed(source: Source, names: Mapping[str, str]) -> tuple[str, tuple[str, ...]]:
    """Rename things in the Python, all at once.

    Args:
        source: The Python.
        names: Old name -> new name.

    Returns:
        The text in which every text that is a name, or a name with `/...` behind it, has changed, and numbers of waypoints
        with them; and the lines that name one of them in another way, which were left.
    """
    found: list[tuple[int, int, str]] = []
    changed: Counter[int] = Counter()
    for node, text in texts_of(source.tree):
        old = text if text in names else text.partition("/")[0]
        if old in names:
            start, end = source.span(node)
            written = source.text[start:end]
            new = written.replace(old, names[old], 1)
            if _says(new, names[old] + text[len(old) :]):
                found.append((start, end, new))
                changed[node.lineno] += 1
    for number, old in _numbers(source):
        if old in names and (new_number := _WAYPOINT.fullmatch(names[old])):
            found.append((*source.span(number), new_number[1]))
    text = source.edited(found)
    return text, _left(source, Source(text), names, changed)


def _left(source: Source, new: Source, names: Mapping[str, str], changed: Counter[int]) -> tuple[str, ...]:
    """Return lines, as they are now, that name a thing more often than was renamed."""
    lines = {line for name in names for line in _patterns(source, name)}
    words = re.compile(rf"\b({'|'.join(map(re.escape, names))})\b")
    for line in range(1, source.line_count + 1):
        if len(words.findall(source.line(line))) > changed[line]:
            lines.add(line)
    return tuple(_shown(new, line) for line in sorted(lines))


def _patterns(source: Source, name: str) -> Iterator[int]:
    """Yield the lines of f-strings that may make a name, such as `f"block{i}"`."""
    for node in ast.walk(source.tree):
        if not isinstance(node, ast.JoinedStr):
            continue
        fixed = [text_of(part) for part in node.values]
        if not any(isinstance(part, str) and re.search(r"[a-z0-9]", part) for part in fixed):
            continue
        pattern = "".join(re.escape(part) if isinstance(part, str) else "[a-z0-9_]+" for part in fixed)
        if re.fullmatch(pattern, name) or re.fullmatch(pattern, f"{name}/x") or re.match(rf"{re.escape(name)}/", _begin(fixed)):
            yield node.lineno


def _begin(fixed: list[str | None]) -> str:
    return fixed[0] or "" if fixed else ""


def _numbers(source: Source) -> Iterator[tuple[ast.Constant, str]]:
    """Yield the numbers of waypoints that are written out, and which they are."""
    for node in ast.walk(source.tree):
        if (place := _place_of_number(node)) is not None and (number := _written_number(place)) is not None:
            yield number, f"waypoint{number.value!r}"


def _place_of_number(node: ast.AST) -> ast.expr | None:
    """Return where the number of a waypoint stands; None where there is none."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in _BY_NUMBER and node.args:
        return node.args[0]
    if isinstance(node, ast.Subscript) and ast.unparse(node.value) == "self.get_waypoints()":
        return node.slice
    return None


def _written_number(place: ast.expr) -> ast.Constant | None:
    return place if isinstance(place, ast.Constant) and type(place.value) is int else None


def _texts(nodes: Iterable[ast.expr]) -> list[str]:
    return [text for node in nodes if (text := text_of(node)) is not None]


def _is_name(text: str, name: str) -> bool:
    return text == name or text.startswith(f"{name}/")


def _says(written: str, value: str) -> bool:
    try:
        return bool(ast.literal_eval(written) == value)
    except (ValueError, SyntaxError):
        return False


def _shown(source: Source, line: int) -> str:
    return f"{line}: {source.line(line).strip()}"
