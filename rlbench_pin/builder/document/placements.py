"""Random placement: the regions of each `SpawnBoundary`, and the elements that are placed in them."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from dataclasses import dataclass, field

from rlbench_pin.builder.document.conditions import (
    Named,
    Reader,
    Written,
    expression,
    list_expression,
    named_element,
    number_text,
)
from rlbench_pin.builder.document.python_text import ListNode, TaskClass, body_of, laid_out
from rlbench_pin.builder.document.texts import Replacement

_BOUNDARY, _NO_ROTATION = "SpawnBoundary", "NO_ROTATION"
_ZERO = (0.0, 0.0, 0.0)
Rotation = tuple[float, float, float]
"""Roll, pitch, yaw [rad]."""


@dataclass(frozen=True)
class SpawnedForm:
    """An element that is placed at random.

    Attributes:
        element: A body or a frame.
        min_rotation: Lower bound of the rotation; None for any yaw.
        max_rotation: Upper bound of the rotation; None for any yaw.
        min_distance: Least distance from elements that were placed before [m]; None for 1 cm.
        ignore_collisions: Whether collisions with elements that were placed before are allowed.
    """

    element: Named | Written
    min_rotation: Rotation | None = None
    max_rotation: Rotation | None = None
    min_distance: float | None = None
    ignore_collisions: bool = False


@dataclass(frozen=True)
class SpawnForm:
    """Names of regions, and the elements that are placed in them in order."""

    regions: tuple[str, ...]
    elements: tuple[SpawnedForm, ...] = ()


@dataclass(eq=False)
class _Boundary:
    """The statements that make, clear and sample a boundary."""

    name: str
    statement: ast.stmt
    regions: ListNode
    clears: list[ast.stmt] = field(default_factory=list)
    samples: list[tuple[ast.stmt, SpawnedForm]] = field(default_factory=list)

    def form(self) -> SpawnForm:
        named = [named_element(item) for item in self.regions.elts]
        return SpawnForm(tuple(item.name for item in named if item is not None), tuple(form for _, form in self.samples))


def read_placements(task: TaskClass) -> tuple[SpawnForm, ...] | None:
    """Return the random placements; None when they are not plain statements."""
    found = _boundaries(task)
    return None if found is None else tuple(boundary.form() for boundary in found)


def with_placements(task: TaskClass, new: Sequence[SpawnForm]) -> str | None:
    """Return the Python with other random placements; None when they are not plain statements now."""
    found, episode, source = _boundaries(task), task.method("init_episode"), task.source
    if found is None or episode is None or not body_of(episode):
        return None
    last = body_of(episode)[-1]
    indent = " " * last.col_offset
    names = Reader(source, task.bindings(None)).elements_above()
    changes: list[Replacement] = []
    for boundary, form in zip(found, new, strict=False):
        changes += _changed(task, boundary, form, last, names)
    for boundary in found[len(new) :]:
        gone = [boundary.statement, *boundary.clears, *(statement for statement, _ in boundary.samples)]
        changes += [source.without(statement) for statement in gone]
    taken = [boundary.name for boundary in found]
    for form in new[len(found) :]:
        name = next(n for n in ("self.boundary", *(f"self.boundary{k}" for k in range(2, 99))) if n not in taken)
        taken.append(name)
        made = laid_out(f"{_BOUNDARY}({_regions(form)})", indent, len(f"{indent}{name} = "))
        samples = (_sample(name, element, names, indent) for element in form.elements)
        changes.append(task.into_init(f"{indent}{name} = {made}\n"))
        changes.append(source.above(last, f"{indent}{name}.clear()\n{''.join(samples)}"))
    return source.edited(changes)


def _boundaries(task: TaskClass) -> list[_Boundary] | None:
    """Return the boundaries of `init_task`; None when one is made or used in another way than a form shows."""
    episode = task.method("init_episode")
    if episode is None:
        return None
    found: dict[str, _Boundary] = {}
    for name, bound in task.bindings(task.init).items():
        value = bound.value
        if isinstance(value, ast.Call) and ast.unparse(value.func) == _BOUNDARY:
            is_plain = bound.is_alone and name.startswith("self.") and len(value.args) == 1 and not value.keywords
            regions = value.args[0] if is_plain else None
            if not isinstance(regions, ListNode) or not all(_is_region(item) for item in regions.elts):
                return None
            found[name] = _Boundary(name, bound.statement, regions)
    made = sum(isinstance(node, ast.Name) and node.id == _BOUNDARY for node in ast.walk(task.node))
    reader = Reader(task.source, task.bindings(episode))
    used = sum(_use(reader, statement, found) for statement in body_of(episode))
    mentioned = sum(isinstance(n, ast.Attribute) and ast.unparse(n) in found for n in ast.walk(task.node))
    return list(found.values()) if made == len(found) and mentioned == len(found) + used else None


def _use(reader: Reader, statement: ast.stmt, found: dict[str, _Boundary]) -> bool:
    """Add a statement that clears or samples a boundary to it; return whether it does either."""
    call = statement.value if isinstance(statement, ast.Expr) else None
    if not isinstance(call, ast.Call) or not isinstance(call.func, ast.Attribute):
        return False
    boundary = found.get(ast.unparse(call.func.value))
    if boundary is None:
        return False
    if call.func.attr == "clear" and not call.args and not call.keywords:
        boundary.clears.append(statement)
        return True
    form = _sampled(reader, call) if call.func.attr == "sample" else None
    if form is not None:
        boundary.samples.append((statement, form))
    return form is not None


def _sampled(reader: Reader, call: ast.Call) -> SpawnedForm | None:
    if len(call.args) != 2 or ast.unparse(call.args[1]) != "rng":
        return None
    element = reader.read(call.args[0])
    options: dict[str, object] = {}
    for keyword in call.keywords:
        value = _ZERO if ast.unparse(keyword.value) == _NO_ROTATION else reader.read(keyword.value)
        if keyword.arg is None or not _is_option(keyword.arg, value):
            return None
        options[keyword.arg] = value
    return SpawnedForm(element, **options) if isinstance(element, Named | Written) else None  # type: ignore[arg-type]


def _is_option(key: str, value: object) -> bool:
    """Whether a form can show an option of `sample`."""
    if key in ("min_rotation", "max_rotation"):
        return isinstance(value, tuple) and len(value) == 3 and all(map(_is_number, value))
    return isinstance(value, bool) if key == "ignore_collisions" else key == "min_distance" and _is_number(value)


def _is_number(value: object) -> bool:
    return isinstance(value, float | int) and not isinstance(value, bool)


def _is_region(node: ast.expr) -> bool:
    named = named_element(node)
    return named is not None and named.kind == "region"


def _changed(task: TaskClass, boundary: _Boundary, form: SpawnForm, last: ast.stmt, names: dict[Named, str]) -> list[Replacement]:
    """Return the replacements after which a boundary has other regions or elements; lines that stay keep their text."""
    source, old, changes = task.source, boundary.form(), list[Replacement]()
    if form.regions != old.regions:
        changes.append((*source.span(boundary.regions), _regions(form)))
    if form.elements == old.elements:
        return changes
    free, lines = list(boundary.samples), ""
    for element in form.elements:
        same = next((sample for sample in free if sample[1] == element), None)
        if same is None:
            lines += _sample(boundary.name, element, names, " " * last.col_offset)
        else:
            free.remove(same)
            lines += source.text[slice(*source.line_span(same[0]))]
    changes += [source.without(statement) for statement, _ in boundary.samples[1:]]
    if boundary.samples:
        changes.append((*source.line_span(boundary.samples[0][0]), lines))
    elif boundary.clears:
        changes.append(source.below(boundary.clears[-1], lines))
    else:
        changes.append(source.above(last, lines))
    return changes


def _regions(form: SpawnForm) -> str:
    return list_expression((Named("region", name) for name in form.regions), {})


def _sample(boundary: str, form: SpawnedForm, names: dict[Named, str], indent: str) -> str:
    """Return the line that samples a place for an element."""
    parts = [expression(form.element, names), "rng"]
    for key in ("min_rotation", "max_rotation"):
        rotation: Rotation | None = getattr(form, key)
        if rotation is not None:
            angles = f"({', '.join(number_text(angle) for angle in rotation)})"
            parts.append(f"{key}={_NO_ROTATION if tuple(rotation) == _ZERO else angles}")
    parts += [f"min_distance={number_text(form.min_distance)}"] if form.min_distance is not None else []
    parts += ["ignore_collisions=True"] if form.ignore_collisions else []
    call = f"{boundary}.sample({', '.join(parts)})"
    return f"{indent}{laid_out(call, indent, len(indent))}\n"
