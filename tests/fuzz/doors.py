"""Doors: what can be called, with good arguments; from each come cases in which one argument is hostile."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Annotated, get_args, get_origin

import numpy as np

from tests.fuzz.cases import Case
from tests.fuzz.hostile import ALL, ARRAY, FLAG, NUMBER, OTHER, SEVERAL, SINGLE, TEXT, WHOLE, Hostile, bent

FUNCTIONS = ("Callable", "IsFree", "OnEpisode", "OnProgress", "Target")
"""Words of annotations of functions, which may raise what they like."""


@dataclass(frozen=True)
class Door:
    """Something that is called, with arguments that it takes.

    Args:
        name: What it is called in reports.
        target: Returns what is called; asked again for each case.
        good: Name of an argument -> a value that it takes, or a function of no argument that makes one (`Fresh`).
        loose: Arguments that take more than their annotation says.
        finite: Whether results are finite.
        good_is_taken: Whether the good arguments are taken; otherwise they are refused as the hostile ones are.
        check: Says what is wrong after a case.
        result: Says what is wrong with a result.
    """

    name: str
    target: Callable[[], Callable[..., object]]
    good: Mapping[str, object] = field(default_factory=dict)
    loose: frozenset[str] = frozenset()
    finite: bool = True
    good_is_taken: bool = True
    check: Callable[[], str] | None = None
    result: Callable[[object], str] | None = None


@dataclass(frozen=True)
class Fresh:
    """A good argument that is made for each call."""

    make: Callable[[], object]


def made(value: object) -> object:
    """Return a good argument."""
    return value.make() if isinstance(value, Fresh) else value


def kind_of(annotation: object) -> str:
    """Return which kind of argument an annotation says."""
    if get_origin(annotation) is Annotated:
        annotation = getattr(get_args(annotation)[0], "__name__", "")
    text = str(annotation).replace(" | None", "").replace("None | ", "").strip("'\"")
    simple = {
        "float": NUMBER,
        "int": WHOLE,
        "bool": FLAG,
        "str": TEXT,
        "PoseLike": ARRAY,
        "ArrayLike": ARRAY,
        "FloatArray": ARRAY,
    }
    if text in simple:
        return simple[text]
    return ARRAY if text in ("Sequence[float]", "Sequence[float] | FloatArray", "np.ndarray") else OTHER


def parameters_of(target: Callable[..., object]) -> dict[str, inspect.Parameter]:
    """Return the arguments that can be given by name."""
    kinds = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
    return {name: p for name, p in inspect.signature(target).parameters.items() if p.kind in kinds}


def missing(door: Door) -> list[str]:
    """Return the arguments of a door that have neither a default nor a good value."""
    return [name for name, p in parameters_of(door.target()).items() if p.default is p.empty and name not in door.good]


def cases_of(door: Door, rng: np.random.Generator, share: float = 1.0) -> Iterator[Case]:
    """Yield cases of a door: the good one, and each hostile value in each argument; a random share of them."""
    yield _case(door, {}, "good arguments", must_take=door.good_is_taken)
    for name, parameter in parameters_of(door.target()).items():
        kind = kind_of(parameter.annotation)
        takes_function = any(word in str(parameter.annotation) for word in FUNCTIONS)
        for value, is_good in _values(kind, door.good.get(name, parameter.default), rng):
            if takes_function and callable(value.make()):
                continue  # it may raise what it likes
            if rng.random() < share:
                strict = name not in door.loose
                refuse = strict and kind in value.refused_by and kind in ALL
                yield _case(
                    door,
                    {name: value},
                    f"{name}={value.words}",
                    must_refuse=refuse,
                    must_take=strict and is_good and door.good_is_taken,
                )


def _values(kind: str, good: object, rng: np.random.Generator) -> Iterator[tuple[Hostile, bool]]:
    for value in (*SINGLE, *SEVERAL):
        yield value, False
    if kind == ARRAY and isinstance(sample := made(good), np.ndarray | list | tuple):
        yield from bent(np.array(sample, dtype=float), rng)


def _case(door: Door, hostile: dict[str, Hostile], words: str, **law: bool) -> Case:
    def call() -> object:
        arguments = {name: made(value) for name, value in door.good.items()}
        arguments.update({name: value.make() for name, value in hostile.items()})
        return door.target()(**arguments)

    return Case(door.name, words, call, check=door.check, check_result=door.result, finite=door.finite, **law)


def functions(module: object, names: Iterable[str], samples: Mapping[str, object], loose: Mapping[str, str]) -> list[Door]:
    """Return the doors of functions and classes of a module, with samples by the names of arguments."""
    return [_door(getattr(module, name), name, samples, loose) for name in names]


def methods(thing: object, samples: Mapping[str, object], loose: Mapping[str, str], skip: Iterable[str] = ()) -> list[Door]:
    """Return the doors of all public methods of an object that take an argument."""
    kind = type(thing)
    found = []
    for name, function in inspect.getmembers(kind, inspect.isfunction):
        if not name.startswith("_") and name not in skip and len(inspect.signature(function).parameters) > 1:
            found.append(_door(getattr(thing, name), f"{kind.__name__}.{name}", samples, loose))
    return found


def _door(target: Callable[..., object], name: str, samples: Mapping[str, object], loose: Mapping[str, str]) -> Door:
    good = {}
    for argument, parameter in parameters_of(target).items():
        if f"{name}.{argument}" in samples:
            good[argument] = samples[f"{name}.{argument}"]
        elif parameter.default is parameter.empty and argument in samples:
            good[argument] = samples[argument]
    is_record = inspect.isclass(target)  # keeps what it was given
    return Door(name, lambda: target, good, frozenset(loose.get(name, "").split()), finite=not is_record)
