"""Random places: the regions of a `SpawnBoundary`, and what is placed in them."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from dataclasses import dataclass, field

from rlbench_pin.builder.document.behaviour.expressions import Reader, expression, named_thing, number_text
from rlbench_pin.builder.document.behaviour.forms import Named, Rotation, SpawnedForm, SpawnForm, Written
from rlbench_pin.builder.document.behaviour.source import Replacement
from rlbench_pin.builder.document.behaviour.task_class import TaskClass, body_of
from rlbench_pin.builder.document.behaviour.writing import above, below, into_init, listed, without

BOUNDARY, STILL = "SpawnBoundary", "NO_ROTATION"
_ZERO = (0.0, 0.0, 0.0)


@dataclass(eq=False)
class _Boundary:
    """Where a boundary is made and used."""

    name: str
    statement: ast.stmt
    regions: ast.List | ast.Tuple
    clears: list[ast.stmt] = field(default_factory=list)
    samples: list[tuple[ast.stmt, SpawnedForm]] = field(default_factory=list)

    def form(self) -> SpawnForm:
        """Return what a form shows of it."""
        named = [named_thing(item) for item in self.regions.elts]
        return SpawnForm(tuple(item.name for item in named if item is not None), tuple(form for _, form in self.samples))


def read_placements(task: TaskClass) -> tuple[SpawnForm, ...] | None:
    """Return what is placed at random; None when it is not done by plain statements."""
    found = _boundaries(task)
    return None if found is None else tuple(boundary.form() for boundary in found)


def written_placements(task: TaskClass, new: Sequence[SpawnForm]) -> str | None:
    """Return the Python that places other things; None when it does not do so by plain statements now."""
    found, episode = _boundaries(task), task.method("init_episode")
    if found is None or episode is None or not body_of(episode):
        return None
    changes: list[Replacement] = []
    for boundary, form in zip(found, new, strict=False):
        changes += _changed(task, boundary, form)
    for boundary in found[len(new) :]:
        gone = [boundary.statement, *boundary.clears, *(statement for statement, _ in boundary.samples)]
        changes += [without(task.source, statement) for statement in gone]
    names = [boundary.name for boundary in found]
    for form in new[len(found) :]:
        name = next(n for n in ("boundary", *(f"boundary{k}" for k in range(2, 99))) if f"self.{n}" not in names)
        names.append(f"self.{name}")
        changes += _made(task, f"self.{name}", form)
    return task.source.edited(_joined(changes))


def _boundaries(task: TaskClass) -> list[_Boundary] | None:
    """Return the boundaries of `init_task`; None when one is made or used in another way than a form shows."""
    init, episode = task.method("init_task"), task.method("init_episode")
    if init is None or episode is None:
        return None
    found: dict[str, _Boundary] = {}
    for name, bound in task.bindings(init).items():
        value = bound.value
        if isinstance(value, ast.Call) and ast.unparse(value.func) == BOUNDARY:
            plain = bound.is_alone and name.startswith("self.") and len(value.args) == 1 and not value.keywords
            regions = value.args[0] if plain else None
            if not isinstance(regions, ast.List | ast.Tuple) or not all(_is_region(item) for item in regions.elts):
                return None
            found[name] = _Boundary(name, bound.statement, regions)
    made = sum(isinstance(node, ast.Name) and node.id == BOUNDARY for node in ast.walk(task.node))
    reader = Reader(task.source, task.bindings(episode))
    used = sum(_use(reader, statement, found) for statement in body_of(episode))
    mentioned = sum(isinstance(n, ast.Attribute) and ast.unparse(n) in found for n in ast.walk(task.node))
    return list(found.values()) if made == len(found) and mentioned == len(found) + used else None


def _use(reader: Reader, statement: ast.stmt, found: dict[str, _Boundary]) -> bool:
    """Note that a statement clears a boundary, or places a thing with it; false when it does neither."""
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
    thing = reader.read(call.args[0])
    said: dict[str, object] = {}
    for keyword in call.keywords:
        value = _ZERO if ast.unparse(keyword.value) == STILL else reader.read(keyword.value)
        if keyword.arg is None or not _is_option(keyword.arg, value):
            return None
        said[keyword.arg] = value
    return SpawnedForm(thing, **said) if isinstance(thing, Named | Written) else None  # type: ignore[arg-type]


def _changed(task: TaskClass, boundary: _Boundary, form: SpawnForm) -> list[Replacement]:
    """Return what to replace so that a boundary places other things, or in other regions."""
    source, old, changes = task.source, boundary.form(), list[Replacement]()
    if form.regions != old.regions:
        changes.append((*source.span(boundary.regions), f"[{', '.join(_region(name) for name in form.regions)}]"))
    if form.things == old.things:
        return changes
    names = _names(task)
    free = list(boundary.samples)
    lines = []
    for thing in form.things:
        same = next((sample for sample in free if sample[1] == thing), None)
        if same is not None:
            free.remove(same)
        start, end = source.line_span(same[0]) if same is not None else (0, 0)
        lines.append(source.text[start:end] if same is not None else _sample(boundary.name, thing, names, _indent(task)))
    anchors = [statement for statement, _ in boundary.samples] or boundary.clears
    changes += [without(source, statement) for statement, _ in boundary.samples[1:]]
    if boundary.samples:
        changes.append((*source.line_span(boundary.samples[0][0]), "".join(lines)))
    elif anchors:
        changes.append(below(source, anchors[-1], "".join(lines)))
    else:
        changes.append(above(source, _first(task), "".join(lines)))
    return changes


def _made(task: TaskClass, name: str, form: SpawnForm) -> list[Replacement]:
    """Return what to replace so that there is another boundary."""
    init, indent = task.method("init_task"), _indent(task)
    assert init is not None, "a task class is found by its init_task"
    regions = listed([_region(region) for region in form.regions], f"{indent}{name} = {BOUNDARY}(", ")")
    names = _names(task)
    lines = [f"{indent}{name}.clear()\n", *(_sample(name, thing, names, indent) for thing in form.things)]
    return [
        into_init(task.source, init, f"{indent}{name} = {BOUNDARY}({regions})\n"),
        above(task.source, _first(task), "".join(lines)),
    ]


def _sample(boundary: str, form: SpawnedForm, names: dict[Named, str], indent: str) -> str:
    parts = [expression(form.thing, names), "rng"]
    parts += [
        f"{key}={_rotation(value)}" for key in ("min_rotation", "max_rotation") if (value := getattr(form, key)) is not None
    ]
    parts += [f"min_distance={number_text(form.min_distance)}"] if form.min_distance is not None else []
    parts += ["ignore_collisions=True"] if form.ignore_collisions else []
    call = f"{indent}{boundary}.sample"
    return f"{call}{listed(parts, call, brackets='()')}\n"


def _rotation(value: Rotation) -> str:
    return STILL if tuple(value) == _ZERO else f"({', '.join(number_text(angle) for angle in value)})"


def _names(task: TaskClass) -> dict[Named, str]:
    """Return the attributes of the task that are things of the scene."""
    found = {}
    for name, bound in task.bindings(None).items():
        thing = named_thing(bound.value)
        if thing is not None:
            found[thing] = name
    return found


def _first(task: TaskClass) -> ast.stmt:
    """Return the last statement of `init_episode`, above which things are placed."""
    episode = task.method("init_episode")
    assert episode is not None, "placements are read from an init_episode"
    return body_of(episode)[-1]


def _indent(task: TaskClass) -> str:
    return " " * _first(task).col_offset


def _region(name: str) -> str:
    return expression(Named("region", name), {})


def _is_option(key: str, value: object) -> bool:
    """Whether a form can show an option of `sample`."""
    if key in ("min_rotation", "max_rotation"):
        return isinstance(value, tuple) and len(value) == 3 and all(map(_is_number, value))
    return isinstance(value, bool) if key == "ignore_collisions" else key == "min_distance" and _is_number(value)


def _is_number(value: object) -> bool:
    return isinstance(value, float | int) and not isinstance(value, bool)


def _is_region(node: ast.expr) -> bool:
    named = named_thing(node)
    return named is not None and named.kind == "region"


def _joined(changes: Sequence[Replacement]) -> list[Replacement]:
    """Put what is written at the same place into one, in order."""
    joined: dict[tuple[int, int], str] = {}
    for start, end, new in changes:
        joined[start, end] = joined.get((start, end), "") + new
    return [(start, end, new) for (start, end), new in joined.items()]
