"""What the task asks for: sentences, variations, what may be grasped, conditions, random placement."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from rlbench_pin.builder.document import Behaviour, Named, SpawnedForm, SpawnForm
from rlbench_pin.builder.view.panels.conditions import Conditions, condition_items
from rlbench_pin.builder.view.panels.vocabulary import Vocabulary
from rlbench_pin.builder.view.session import Session
from rlbench_pin.builder.view.widgets import Button, Check, Choice, Entry, Fold, Item, Note, Number

_LOCKED = Note("The Python says this in a way that no form can edit; see *Files*.")
_NO_TURN = (0.0, 0.0, 0.0)


def behaviour_items(session: Session) -> list[Item]:
    """Return forms for what the Python says."""
    behaviour: Behaviour = session.behaviour

    def put(field: str) -> Callable[[object], None]:
        return lambda value: session.do(lambda document: document.set_behaviour(field, value))

    def conditions(field: str) -> Callable[[Conditions], None]:
        return lambda value: session.do(lambda document: document.set_behaviour(field, value))

    vocabulary = Vocabulary(session.spec, behaviour.graspable or ())
    return [
        Fold("Words", _word_items(behaviour, put)),
        Fold("Variations", _variation_items(behaviour, put), is_open=False),
        Fold("May be grasped", _graspable_items(session, behaviour, put("graspable"))),
        Fold("Success: all at the same instant", _condition_items(vocabulary, behaviour.success, conditions("success"))),
        Fold("Failure", _condition_items(vocabulary, behaviour.failure, conditions("failure")), is_open=False),
        Fold("Random places", _placement_items(session, behaviour.placements, put("placements")), is_open=False),
    ]


def _word_items(behaviour: Behaviour, put: Callable[[str], Callable[[object], None]]) -> list[Item]:
    items: list[Item] = []
    for label, field, text in (
        ("Title", "title", behaviour.title),
        ("What varies, what counts", "description", behaviour.description),
    ):
        items.append(_LOCKED if text is None else Entry(label, text, put(field), f"Apply {field}", lines=field == "description"))
    if behaviour.instructions is None:
        return [*items, Note("Sentences: the Python makes them; see *Files*.")]
    groups = behaviour.instructions
    for number, group in enumerate(groups):
        label = "Sentences, one a line" if len(groups) == 1 else f"Variation {number}, one sentence a line"
        items.append(
            Entry(label, "\n".join(group), _sentences(groups, number, put("instructions")), "Apply sentences", lines=True)
        )
    return items


def _sentences(groups: tuple[tuple[str, ...], ...], number: int, put: Callable[[object], None]) -> Callable[[str], None]:
    def commit(text: str) -> None:
        lines = tuple(line.strip() for line in text.splitlines() if line.strip())
        put(tuple(lines if k == number else group for k, group in enumerate(groups)))

    return commit


def _variation_items(behaviour: Behaviour, put: Callable[[str], Callable[[object], None]]) -> list[Item]:
    items: list[Item] = []
    if behaviour.variation_count is None:
        items.append(Note("How many variations there are is said in the Python; see *Files*."))
    else:
        count = put("variation_count")
        items.append(Number("Variations", behaviour.variation_count, lambda value: count(max(1, round(value))), 1.0, 1.0))
    if (groups := behaviour.instructions) is not None:
        instructions = put("instructions")
        items.append(Button("Add a variation with sentences of its own", lambda: instructions((*groups, groups[-1]))))
        if len(groups) > 1:
            items.append(Button("Remove the last variation", lambda: instructions(groups[:-1])))
    if behaviour.solved_by_chance is not None:
        hint = "Whether a flailing arm may reach the goal now and then"
        items.append(Check("Solved by chance", behaviour.solved_by_chance, put("solved_by_chance"), hint))
    return items


def _graspable_items(session: Session, behaviour: Behaviour, put: Callable[[object], None]) -> list[Item]:
    names = behaviour.graspable
    if names is None:
        return [_LOCKED]

    def change(name: str) -> Callable[[bool], None]:
        rest = tuple(other for other in names if other != name)
        return lambda wanted: put((*rest, name) if wanted else rest)

    bodies = [body.name for body in session.spec.body if body.collides and (not body.fixed or body.name in names)]
    others = [name for name in names if name not in bodies]
    items: list[Item] = [Check(name, name in names, change(name)) for name in (*bodies, *others)]
    return items or [Note("Nothing is here that moves: *Add* a body that is not fixed.")]


def _condition_items(vocabulary: Vocabulary, conditions: Conditions | None, put: Callable[[Conditions], None]) -> list[Item]:
    return [_LOCKED] if conditions is None else condition_items(vocabulary, conditions, put)


# Random places ---------------------------------------------------------------------------------------------------------------


def _placement_items(session: Session, forms: tuple[SpawnForm, ...] | None, put: Callable[[object], None]) -> list[Item]:
    if forms is None:
        return [_LOCKED]
    regions = tuple(region.name for region in session.spec.region)
    if not regions:
        return [Note("Add a region first: things are placed in it at random.")]
    items: list[Item] = []
    for number, form in enumerate(forms):
        others = forms[:number], forms[number + 1 :]
        items.append(_spawn_item(session, form, lambda new, o=others: put((*o[0], *new, *o[1]))))  # type: ignore[misc]
    used = {name for form in forms for name in form.regions}
    items += [_place_in(name, forms, put) for name in regions if name not in used]
    return items


def _place_in(region: str, forms: tuple[SpawnForm, ...], put: Callable[[object], None]) -> Button:
    return Button(f"Place things in {region}", lambda: put((*forms, SpawnForm((region,)))))


def _spawn_item(session: Session, form: SpawnForm, put: Callable[[tuple[SpawnForm, ...]], None]) -> Fold:
    items: list[Item] = []
    for body in session.spec.body:
        thing = Named("body", body.name)
        spawned = next((s for s in form.things if s.thing == thing), None)
        rest = tuple(s for s in form.things if s.thing != thing)

        def change(wanted: bool, thing: Named = thing, rest: tuple[SpawnedForm, ...] = rest) -> None:
            put((replace(form, things=(*rest, SpawnedForm(thing)) if wanted else rest),))

        items.append(Check(body.name, spawned is not None, change))
        if spawned is not None:
            items += _spawned_items(form, spawned, put)
    items.append(Button("Remove", lambda: put(()), "red"))
    return Fold(f"In {', '.join(form.regions)}", items)


def _spawned_items(form: SpawnForm, spawned: SpawnedForm, put: Callable[[tuple[SpawnForm, ...]], None]) -> list[Item]:
    def change(new: SpawnedForm) -> None:
        put((replace(form, things=tuple(new if s.thing == spawned.thing else s for s in form.things)),))

    def turn(word: str) -> None:
        bound = None if word == "any yaw" else _NO_TURN
        change(replace(spawned, min_rotation=bound, max_rotation=bound))

    turns = (
        "any yaw" if spawned.min_rotation is None else "not turned" if spawned.min_rotation == spawned.max_rotation else "bounds"
    )
    options = ("any yaw", "not turned", *([turns] if turns == "bounds" else []))
    return [
        Choice("\u2003turned by", turns, options, turn),
        Number(
            "\u2003at least apart [m]", spawned.min_distance or 0.01, lambda v: change(replace(spawned, min_distance=v)), 0.01
        ),
    ]
