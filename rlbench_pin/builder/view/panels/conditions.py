"""Conditions as forms: what they are made of, more of them, fewer of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from rlbench_pin.builder.document import Argument, ConditionForm, ConditionKind, Named, Parameter, Written, condition_kinds
from rlbench_pin.builder.view.panels.vocabulary import Vocabulary
from rlbench_pin.builder.view.widgets import Button, Check, Choice, Entry, Fold, Item, Note, Number

Conditions = tuple[ConditionForm | Written, ...]
Put = Callable[[Conditions], None]
"""Called with the conditions as they are to be."""


def condition_items(vocabulary: Vocabulary, conditions: Conditions, put: Put) -> list[Item]:
    """Return a fold for each condition, and buttons that add one.

    Args:
        vocabulary: What conditions can be about.
        conditions: As they are.
        put: Called with changed ones.
    """
    items: list[Item] = [_add_item(vocabulary, conditions, put)]  # first, so that it stays open
    if not conditions:
        items.append(Note("None yet: open *Add condition*. A condition is about things that the scene has."))
    for number, form in enumerate(conditions):
        others = conditions[:number], conditions[number + 1 :]
        remove = Button("Remove", lambda o=others: put((*o[0], *o[1])), "red")  # type: ignore[misc]
        if isinstance(form, Written):
            items.append(Fold(f"{number + 1}. written by hand", [Note(f"`{form.text}`"), remove]))
            continue
        change = _changer(others, put)
        items.append(Fold(f"{number + 1}. {form.kind}", [*_form_items(vocabulary, form, change), remove]))
    return items


def _changer(others: tuple[Conditions, Conditions], put: Put) -> Callable[[ConditionForm], None]:
    return lambda form: put((*others[0], form, *others[1]))


def _add_item(vocabulary: Vocabulary, conditions: Conditions, put: Put) -> Fold:
    buttons: list[Item] = []
    for kind in condition_kinds():
        form = vocabulary.first(kind)
        why = "" if form is not None else f"There is no {vocabulary.lacking(kind)} in the scene."
        press = (lambda f=form: put((*conditions, f))) if form is not None else _nothing  # type: ignore[misc]
        buttons.append(Button(kind.name, press, hint=why or kind.text, disabled=form is None))
    return Fold("Add condition", buttons, is_open=False)


def _nothing() -> None:
    """Nothing can be added."""


def _form_items(vocabulary: Vocabulary, form: ConditionForm, change: Callable[[ConditionForm], None]) -> list[Item]:
    kind = next((kind for kind in condition_kinds() if kind.name == form.kind), None)
    if kind is None:
        return [Note(f"`{form.kind}` has no form; edit the text.")]
    items: list[Item] = [Note(kind.text)]
    for parameter in kind.parameters:
        items += _parameter_items(vocabulary, kind, parameter, form, change)
    return items


def _parameter_items(
    vocabulary: Vocabulary,
    kind: ConditionKind,
    parameter: Parameter,
    form: ConditionForm,
    change: Callable[[ConditionForm], None],
) -> list[Item]:
    value: Any = form.arguments.get(parameter.name, parameter.default)

    def put(new: Argument) -> None:
        given = {**form.arguments, parameter.name: new}
        if not parameter.required and new == parameter.default:
            del given[parameter.name]
        change(ConditionForm(form.kind, {p.name: given[p.name] for p in kind.parameters if p.name in given}))

    label = parameter.name.replace("_", " ")
    if isinstance(value, Written):
        return [Note(f"{label}: `{value.text}`")]
    if parameter.kind in ("body", "place", "joint", "frame", "sensor"):
        return [_thing_item(vocabulary, parameter, label, value, put)]
    if parameter.kind == "flag":
        return [Check(label, bool(value), put)]
    if parameter.kind in ("number", "whole") and isinstance(value, int | float):
        whole = parameter.kind == "whole"
        return [Number(label, value, lambda v: put(round(v) if whole else round(v, 6)), 1.0 if whole else 0.01)]
    if parameter.kind == "conditions":
        members = value if isinstance(value, tuple) else ()
        return condition_items(vocabulary, members, put)
    if parameter.kind == "places":
        chosen = value if isinstance(value, tuple) else ()
        return [_member(thing, thing in chosen, chosen, put) for thing in vocabulary.things("place")]
    return [Entry(f"{label}, numbers", _numbers_text(value), lambda text: put(_numbers(text)), f"Apply {label}")]


def _thing_item(
    vocabulary: Vocabulary, parameter: Parameter, label: str, value: Argument, put: Callable[[Argument], None]
) -> Choice:
    things = {thing.name: thing for thing in vocabulary.things(parameter.kind)}
    none = () if parameter.required else ("world",)
    name = value.name if isinstance(value, Named) else "world"
    options = tuple(dict.fromkeys([*none, *things, name]))
    return Choice(label, name, options, lambda word: put(things.get(word)))


def _member(thing: Named, is_in: bool, chosen: Sequence[Argument], put: Callable[[Argument], None]) -> Check:
    def change(wanted: bool) -> None:
        rest = tuple(other for other in chosen if other != thing)
        put((*rest, thing) if wanted else rest)

    return Check(thing.name, is_in, change)


def _numbers_text(value: Argument) -> str:
    if not isinstance(value, tuple):
        return ""
    return "; ".join(_numbers_text(row) for row in value) if value and isinstance(value[0], tuple) else ", ".join(map(str, value))


def _numbers(text: str) -> Argument:
    """Return numbers between commas, or rows of them between semicolons; what is no number is left out."""
    rows = [tuple(_number(word) for word in row.split(",") if _is_number(word)) for row in text.split(";")]
    return rows[0] if len(rows) == 1 else tuple(row for row in rows if row)


def _number(word: str) -> float:
    return float(word)


def _is_number(word: str) -> bool:
    try:
        return abs(float(word)) < 1e9
    except ValueError:
        return False
