"""The tab *Behaviour*: sentences, variations, graspable bodies, conditions and random placement in the Python file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from rlbench_pin.builder.document import (
    Argument,
    Behaviour,
    ConditionForm,
    ConditionKind,
    Named,
    Parameter,
    SpawnedForm,
    SpawnForm,
    Written,
    condition_kinds,
)
from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.widgets import Panel
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.scene import SceneSpec, resolve_asset
from rlbench_pin.urdf import read_urdf

Conditions = tuple[ConditionForm | Written, ...]
Put = Callable[[Conditions], None]
"""Receives changed conditions."""
SetField = Callable[[str], Callable[[Any], None]]
"""Returns a function that sets a field of the behaviour."""
_LOCKED = "No form can edit this part of the Python; see *Files*."
_NO_ROTATION = (0.0, 0.0, 0.0)
_FIRST: Mapping[str, Argument] = {"number": 0.1, "whole": 1, "flag": False, "numbers": (1.0, 0.0, 0.0)}
_KIND_NAMES = {"place": "body or frame", "conditions": "condition", "places": "body or frame"}


def show_behaviour(panel: Panel, session: Session) -> None:
    """Show forms for the behaviour in the Python file."""
    behaviour = session.document.behaviour

    def put(field: str) -> Callable[[Any], None]:
        return lambda value: session.do(lambda document: document.set_behaviour(field, value))

    vocabulary = Vocabulary(session.spec, behaviour.graspable or ())
    with panel.folder("Words") as folder:
        _show_words(folder, behaviour, put)
    with panel.folder("Variations", is_open=False) as folder:
        _show_variations(folder, behaviour, put)
    with panel.folder("May be grasped") as folder:
        _show_graspable(folder, session, behaviour.graspable, put("graspable"))
    with panel.folder("Kinds of conditions", is_open=False) as folder:
        folder.note("\n".join(f"- **{kind.name}**: {kind.text}" for kind in condition_kinds()))
    with panel.folder("Success: all at the same instant") as folder:
        _show_conditions(folder, vocabulary, behaviour.success, put("success"))
    with panel.folder("Failure", is_open=False) as folder:
        _show_conditions(folder, vocabulary, behaviour.failure, put("failure"))
    with panel.folder("Random places", is_open=False) as folder:
        _show_placements(folder, session, behaviour.placements, put("placements"))


def _show_words(panel: Panel, behaviour: Behaviour, put: SetField) -> None:
    texts = (("Title", "title", behaviour.title), ("Variations and success", "description", behaviour.description))
    for label, field, text in texts:
        if text is None:
            panel.note(_LOCKED)
        else:
            panel.entry(label, text, put(field), f"Apply {field}", multiline=field == "description")
    groups = behaviour.instructions
    if groups is None:
        panel.note("Sentences: the Python computes them; see *Files*.")
        return

    def commit(number: int, text: str) -> None:
        lines = tuple(line.strip() for line in text.splitlines() if line.strip())
        put("instructions")(tuple(lines if k == number else group for k, group in enumerate(groups)))

    for number, group in enumerate(groups):
        label = "Sentences, one per line" if len(groups) == 1 else f"Variation {number}, one sentence per line"
        text = "\n".join(group)
        panel.entry(label, text, lambda new, k=number: commit(k, new), "Apply sentences", multiline=True)  # type: ignore[misc]


def _show_variations(panel: Panel, behaviour: Behaviour, put: SetField) -> None:
    if behaviour.variation_count is None:
        panel.note("The Python computes the number of variations; see *Files*.")
    else:
        count = put("variation_count")
        panel.number("Variations", behaviour.variation_count, lambda value: count(max(1, round(value))), 1.0, 1.0)
    if (groups := behaviour.instructions) is not None:
        instructions = put("instructions")
        panel.button("Add a variation with its own sentences", lambda: instructions((*groups, groups[-1])))
        if len(groups) > 1:
            panel.button("Remove the last variation", lambda: instructions(groups[:-1]))
    if behaviour.solved_by_chance is not None:
        hint = "Whether random actions may sometimes reach the goal"
        panel.checkbox("Solved by chance", behaviour.solved_by_chance, put("solved_by_chance"), hint)


def _show_graspable(panel: Panel, session: Session, names: tuple[str, ...] | None, put: Callable[[Any], None]) -> None:
    if names is None:
        panel.note(_LOCKED)
        return

    def change(name: str, wanted: bool) -> None:
        rest = tuple(other for other in names if other != name)
        put((*rest, name) if wanted else rest)

    bodies = [body.name for body in session.spec.body if body.collides and (not body.fixed or body.name in names)]
    shown = (*bodies, *(name for name in names if name not in bodies))
    for name in shown:
        panel.checkbox(name, name in names, lambda wanted, name=name: change(name, wanted))  # type: ignore[misc]
    if not shown:
        panel.note("No body can move: *Add* a body that is not fixed.")


# Random places -------------------------------------------------------------------------------------------------------


def _show_placements(panel: Panel, session: Session, forms: tuple[SpawnForm, ...] | None, put: Callable[[Any], None]) -> None:
    if forms is None:
        panel.note(_LOCKED)
        return
    regions = tuple(region.name for region in session.spec.region)
    if not regions:
        panel.note("Add a region first: bodies are placed in it at random.")
        return
    for number, form in enumerate(forms):
        before, behind = forms[:number], forms[number + 1 :]
        _show_spawn(panel, session, form, lambda new, b=before, a=behind: put((*b, *new, *a)))  # type: ignore[misc]
    used = {name for form in forms for name in form.regions}
    for region in regions:
        if region not in used:
            new = (*forms, SpawnForm((region,)))
            panel.button(f"Place bodies in {region}", lambda new=new: put(new))  # type: ignore[misc]


def _show_spawn(panel: Panel, session: Session, form: SpawnForm, put: Callable[[tuple[SpawnForm, ...]], None]) -> None:
    def show_body(name: str) -> None:
        body = Named("body", name)
        spawned = next((s for s in form.elements if s.element == body), None)
        rest = tuple(s for s in form.elements if s.element != body)

        def change(wanted: bool) -> None:
            put((replace(form, elements=(*rest, SpawnedForm(body)) if wanted else rest),))

        folder.checkbox(name, spawned is not None, change)
        if spawned is not None:
            _show_spawned(folder, form, spawned, put)

    with panel.folder(f"In {', '.join(form.regions)}") as folder:
        for body_spec in session.spec.body:
            show_body(body_spec.name)
        folder.button("Remove", lambda: put(()), "red")


def _show_spawned(panel: Panel, form: SpawnForm, spawned: SpawnedForm, put: Callable[[tuple[SpawnForm, ...]], None]) -> None:
    def change(**values: Any) -> None:
        new = replace(spawned, **values)
        put((replace(form, elements=tuple(new if s.element == spawned.element else s for s in form.elements)),))

    def set_rotation(word: str) -> None:
        bound = None if word == "any yaw" else _NO_ROTATION
        change(min_rotation=bound, max_rotation=bound)

    rotation = "any yaw"
    if spawned.min_rotation is not None:
        rotation = "not rotated" if spawned.min_rotation == spawned.max_rotation else "bounds"
    options = ("any yaw", "not rotated", *(["bounds"] if rotation == "bounds" else []))
    distance = spawned.min_distance or 0.01
    panel.dropdown("\u2003rotated by", rotation, options, set_rotation)
    panel.number("\u2003at least apart [m]", distance, lambda value: change(min_distance=value), 0.01)


# Conditions ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Vocabulary:
    """The elements of a scene that conditions can name; graspable bodies come first."""

    spec: SceneSpec
    graspable: tuple[str, ...] = ()

    def names(self, kind: str) -> tuple[Named, ...]:
        """Return all elements for a kind of parameter: body, place, joint, frame or sensor."""
        bodies = sorted((body.name for body in self.spec.body), key=lambda name: name not in self.graspable)
        frames = [element.name for element in (*self.spec.frame, *self.spec.sensor, *self.spec.region, *self.spec.waypoint)]
        if kind == "body":
            return tuple(Named("body", name) for name in bodies)
        if kind == "sensor":
            return tuple(Named("sensor", sensor.name) for sensor in self.spec.sensor)
        if kind == "joint":
            return tuple(Named("joint", name) for name in self._joints())
        if kind == "frame":
            return tuple(Named("frame", name) for name in frames)
        return (*(Named("body", name) for name in bodies), *(Named("frame", name) for name in frames))

    def _joints(self) -> tuple[str, ...]:
        """Return `<body>/<joint>` of all movable joints."""
        found = []
        for body in self.spec.body:
            try:
                joints = read_urdf(resolve_asset(self.spec, body.asset)).joint_limits
            except RlbenchPinError:
                continue
            found += [f"{body.name}/{joint}" for joint in joints]
        return tuple(found)

    def first(self, kind: ConditionKind) -> ConditionForm | str:
        """Return a condition of a kind with the first elements that fit, or what the scene lacks for it."""
        arguments: dict[str, Argument] = {}
        for parameter in kind.parameters:
            if parameter.required:
                value = self._first_value(parameter)
                if value is None:
                    return _KIND_NAMES.get(parameter.kind, parameter.kind)
                arguments[parameter.name] = value
        return ConditionForm(kind.name, arguments)

    def _first_value(self, parameter: Parameter) -> Argument:
        if parameter.kind in _FIRST:
            return _FIRST[parameter.kind]
        if parameter.kind == "points":
            return ((0.0, 0.0, 0.0),)
        if parameter.kind == "conditions":
            return (ConditionForm("NothingGrasped"),)
        names = self.names("place" if parameter.kind == "places" else parameter.kind)
        if not names:
            return None
        return (names[0],) if parameter.kind == "places" else names[0]


def _show_conditions(panel: Panel, vocabulary: Vocabulary, conditions: Conditions | None, put: Put) -> None:
    """Show buttons that add a condition, and a folder for each one."""
    if conditions is None:
        panel.note(_LOCKED)
        return
    with panel.folder("Add condition", is_open=False) as folder:  # first, so that it stays open
        for kind in condition_kinds():
            form = vocabulary.first(kind)
            hint = f"There is no {form} in the scene." if isinstance(form, str) else kind.text
            new = conditions if isinstance(form, str) else (*conditions, form)
            folder.button(kind.name, lambda new=new: put(new), hint=hint, disabled=isinstance(form, str))  # type: ignore[misc]
    if not conditions:
        panel.note("None yet: open *Add condition*. A condition is about elements of the scene.")
    for number, condition in enumerate(conditions):
        _show_condition(panel, vocabulary, conditions, number, condition, put)


def _show_condition(
    panel: Panel, vocabulary: Vocabulary, conditions: Conditions, number: int, condition: ConditionForm | Written, put: Put
) -> None:
    before, behind = conditions[:number], conditions[number + 1 :]
    title = "written by hand" if isinstance(condition, Written) else condition.kind
    with panel.folder(f"{number + 1}. {title}") as folder:
        if isinstance(condition, Written):
            folder.note(f"`{condition.text}`")
        else:
            _show_form(folder, vocabulary, condition, lambda form: put((*before, form, *behind)))
        folder.button("Remove", lambda: put((*before, *behind)), "red")


def _show_form(panel: Panel, vocabulary: Vocabulary, form: ConditionForm, change: Callable[[ConditionForm], None]) -> None:
    kind = next((kind for kind in condition_kinds() if kind.name == form.kind), None)
    if kind is None:
        panel.note(f"`{form.kind}` has no form; edit the text.")
        return

    def put(parameter: Parameter, new: Argument) -> None:
        given = {**form.arguments, parameter.name: new}
        if not parameter.required and new == parameter.default:
            del given[parameter.name]
        change(ConditionForm(form.kind, {p.name: given[p.name] for p in kind.parameters if p.name in given}))

    panel.note(kind.text)
    for parameter in kind.parameters:
        value = form.arguments.get(parameter.name, parameter.default)
        _show_parameter(panel, vocabulary, parameter, value, lambda new, p=parameter: put(p, new))  # type: ignore[misc]


def _show_parameter(
    panel: Panel, vocabulary: Vocabulary, parameter: Parameter, value: Any, put: Callable[[Argument], None]
) -> None:
    label, kind = parameter.name.replace("_", " "), parameter.kind
    if isinstance(value, Written):
        panel.note(f"{label}: `{value.text}`")
    elif kind in ("body", "place", "joint", "frame", "sensor"):
        names = {named.name: named for named in vocabulary.names(kind)}
        present = value.name if isinstance(value, Named) else "world"
        options = tuple(dict.fromkeys([*(() if parameter.required else ("world",)), *names, present]))
        panel.dropdown(label, present, options, lambda word: put(names.get(word)))
    elif kind == "flag":
        panel.checkbox(label, bool(value), put)
    elif kind in ("number", "whole") and isinstance(value, int | float):
        whole = kind == "whole"
        panel.number(label, value, lambda v: put(round(v) if whole else round(v, 6)), 1.0 if whole else 0.01)
    elif kind == "conditions":
        _show_conditions(panel, vocabulary, value if isinstance(value, tuple) else (), put)
    elif kind == "places":
        chosen = value if isinstance(value, tuple) else ()
        for named in vocabulary.names("place"):
            rest = tuple(other for other in chosen if other != named)
            both = (rest, (*rest, named))
            panel.checkbox(named.name, named in chosen, lambda wanted, both=both: put(both[wanted]))  # type: ignore[misc]
    else:
        text = _format_numbers(value)
        panel.entry(f"{label}, numbers", text, lambda text: put(_read_numbers(text)), f"Apply {label}")


def _format_numbers(value: Argument) -> str:
    if not isinstance(value, tuple):
        return ""
    is_table = bool(value) and isinstance(value[0], tuple)
    return "; ".join(_format_numbers(row) for row in value) if is_table else ", ".join(map(str, value))


def _read_numbers(text: str) -> Argument:
    """Return numbers between commas, or rows of them between semicolons; other words are left out."""
    rows = [tuple(float(word) for word in row.split(",") if _is_number(word)) for row in text.split(";")]
    return rows[0] if len(rows) == 1 else tuple(row for row in rows if row)


def _is_number(word: str) -> bool:
    try:
        return abs(float(word)) < 1e9
    except ValueError:
        return False
