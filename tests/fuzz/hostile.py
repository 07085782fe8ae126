"""Values that no door expects: of wrong kinds, shapes and sizes; and what each kind of argument must never take."""

from __future__ import annotations

import fractions
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from decimal import Decimal
from pathlib import Path

import numpy as np

NUMBER, WHOLE, FLAG, TEXT, ARRAY, OTHER = "number", "whole", "flag", "text", "array", "other"
NUMERIC = frozenset({NUMBER, WHOLE, ARRAY})
ALL = frozenset({NUMBER, WHOLE, FLAG, TEXT, ARRAY})


class Stranger:
    """An object of nobody's, which cannot be shown, compared or hashed."""

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        raise RuntimeError("I will not be shown")

    def __eq__(self, other: object) -> bool:
        raise RuntimeError("I will not be compared")


class NoNumber:
    """Says that it is an array and a number, and is neither."""

    def __array__(self, *_: object, **__: object) -> np.ndarray:
        raise RuntimeError("no array")

    def __float__(self) -> float:
        raise RuntimeError("no number")

    __int__ = __index__ = __len__ = __float__  # type: ignore[assignment]


@dataclass(frozen=True)
class Hostile:
    """One value, what it is called in reports, and the kinds of arguments that must not take it."""

    words: str
    make: Callable[[], object] = field(repr=False)
    refused_by: frozenset[str] = frozenset()


def _plain(value: object, refused_by: frozenset[str] = frozenset()) -> Hostile:
    return Hostile(ascii(value)[:40], lambda: value, refused_by)


def _nested(depth: int) -> list[object]:
    result: list[object] = []
    for _ in range(depth):
        result = [result]
    return result


def _cyclic() -> list[object]:
    result: list[object] = []
    result.append(result)
    return result


SINGLE: tuple[Hostile, ...] = (
    _plain(float("nan"), ALL), _plain(np.float32("nan"), ALL), _plain(float("inf"), ALL - {NUMBER}),
    _plain(-math.inf, ALL - {NUMBER}), _plain(1e300, frozenset({TEXT, FLAG, WHOLE})), _plain(-1e300, frozenset({TEXT, WHOLE})),
    _plain(5e-324, frozenset({TEXT, WHOLE})), _plain(1.5, frozenset({TEXT, WHOLE, FLAG})), _plain(-0.0),
    _plain(np.float64(2.0), frozenset({TEXT})), _plain(0), _plain(-1, frozenset({TEXT})), _plain(-(2**31)),
    _plain(2**31), _plain(2**63), _plain(2**64), _plain(2**200, frozenset({TEXT, FLAG})), _plain(10**400, ALL - {WHOLE}),
    _plain(np.uint8(255)), _plain(np.int8(-128)), _plain(np.uint64(2**64 - 1)), _plain(np.int64(-(2**63))),
    _plain(True, NUMERIC - {ARRAY}), _plain(np.bool_(True), NUMERIC - {ARRAY}), _plain(1j, ALL), _plain(np.complex64(1), ALL),
    _plain("x", ALL - {TEXT}), _plain("1", ALL - {TEXT}), _plain("", ALL - {TEXT}), _plain("nan", ALL - {TEXT}),
    _plain("../../etc/passwd", ALL - {TEXT}), _plain("a\0b", ALL - {TEXT}), _plain("ünï☃\ud800", ALL - {TEXT}),
    Hostile("'x' * 100000", lambda: "x" * 100_000, ALL - {TEXT}), _plain(b"1", ALL), _plain(b"\xff", ALL), _plain(None),
    _plain(Ellipsis, ALL), _plain(NotImplemented, ALL), _plain(int, ALL), _plain(print, ALL), _plain(Path("nowhere"), NUMERIC),
    _plain(Decimal("1.5"), frozenset({WHOLE, TEXT})), _plain(fractions.Fraction(1, 2), frozenset({WHOLE, TEXT})),
    _plain(np.datetime64("2020-01-01"), ALL), _plain(np.timedelta64(1, "s"), ALL), _plain(np.ma.masked, ALL),
    Hostile("Stranger()", Stranger, ALL), Hostile("NoNumber()", NoNumber, ALL), Hostile("object()", object, ALL),
    Hostile("lambda: 1", lambda: lambda: 1, ALL), Hostile("a generator", lambda: (x for x in (1, 2)), ALL),
)  # fmt: skip
"""Single values."""

SEVERAL: tuple[Hostile, ...] = (
    _plain([]), _plain(()), _plain({}, ALL), _plain(set(), ALL), _plain([None], ALL), _plain([[1], [2, 3]], ALL),
    _plain(["1", "2"], ALL), _plain([1j], ALL), _plain((1, 0)), _plain({"a": 1}, ALL), _plain({1: 2}, ALL), _plain([True]),
    Hostile("[[[...]]] 60 deep", lambda: _nested(60), ALL), Hostile("a list in itself", _cyclic, ALL),
    Hostile("zeros(3)", lambda: np.zeros(3)), Hostile("zeros(7)", lambda: np.zeros(7)), Hostile("zeros(0)", lambda: np.zeros(0)),
    Hostile("zeros((7, 7))", lambda: np.zeros((7, 7))), Hostile("zeros((0, 7))", lambda: np.zeros((0, 7))),
    Hostile("ones(1000)", lambda: np.ones(1000)), Hostile("full(7, nan)", lambda: np.full(7, np.nan), ALL),
    Hostile("full(7, inf)", lambda: np.full(7, np.inf), ALL), Hostile("full(7, 1e300)", lambda: np.full(7, 1e300)),
    Hostile("full(8, 1e308)", lambda: np.full(8, 1e308)), Hostile("full(7, '1')", lambda: np.full(7, "1"), ALL),
    Hostile("full(7, None)", lambda: np.full(7, None), ALL), Hostile("complex (7,)", lambda: np.zeros(7, complex), ALL),
    Hostile("dates (7,)", lambda: np.zeros(7, "datetime64[s]"), ALL),
    Hostile("masked (7,)", lambda: np.ma.masked_array(np.zeros(7), [1] + [0] * 6), ALL),
    Hostile("record array", lambda: np.zeros(7, [("a", float)]), ALL), Hostile("array('x')", lambda: np.array("x"), ALL),
    Hostile("array(nan)", lambda: np.array(np.nan), ALL), Hostile("zeros((2,) * 20)", lambda: np.zeros((2,) * 20)),
)  # fmt: skip
"""Containers and arrays."""


def bent(sample: np.ndarray, rng: np.random.Generator) -> Iterator[tuple[Hostile, bool]]:
    """Yield changes of a good array, and whether the change leaves it good: same numbers in another dress."""
    flat = tuple(np.ndindex(sample.shape)) or ((),)
    place = flat[int(rng.integers(len(flat)))]

    def put(value: object, kind: object = float) -> Callable[[], np.ndarray]:
        def make() -> np.ndarray:
            array = np.array(sample, dtype=kind)
            array[place] = value
            return array

        return make

    for value in (np.nan, np.inf, -np.inf):
        yield Hostile(f"good but {value} at {place}", put(value), ALL), False
    for number in (1e300, -1e300, 5e-324, 1e9, -1e9):
        yield Hostile(f"good but {number} at {place}", put(number)), False
    for value, kind in ((1j, complex), ("x", object), (None, object)):
        yield Hostile(f"good but {value!r} at {place}", put(value, kind), ALL), False
    yield Hostile("as text", lambda: sample.astype(str), ALL), False
    yield Hostile("one masked", lambda: np.ma.masked_array(sample, np.arange(sample.size).reshape(sample.shape) == 0), ALL), False
    yield Hostile("one number more", lambda: np.concatenate([sample.ravel(), [0.0]]), frozenset({ARRAY})), False
    yield Hostile("one number less", lambda: sample.ravel()[:-1], frozenset({ARRAY})), False
    yield Hostile("one axis more, at the end", lambda: sample[..., None], frozenset({ARRAY})), False
    yield Hostile("as a list", sample.tolist), True
    yield Hostile("backwards in memory", lambda: sample[::-1].copy()[::-1] if sample.ndim else sample), True
    yield Hostile("big-endian", lambda: sample.astype(">f8")), True
    yield Hostile("read-only", lambda: np.lib.stride_tricks.as_strided(sample, writeable=False)), True
