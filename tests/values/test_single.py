"""Numbers are numbers, whole numbers are whole, switches are switches: anything else is a typed error that names it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from rlbench_pin.errors import InvalidArgument, InvalidValue, RlbenchPinError, TaskEnvironmentError, UnknownName
from rlbench_pin.values import (
    LARGEST_SEED,
    as_choice,
    as_flag,
    as_interval,
    as_number,
    as_picture_size,
    as_seed,
    as_whole,
)

NO_NUMBERS = ("1", b"1", None, True, np.True_, 1j, [1.0], np.array([1.0]), np.datetime64("2026-01-01"), object(), float("nan"))


class Unshowable:
    """An object that refuses to be shown."""

    def __repr__(self) -> str:
        """Raise."""
        raise RuntimeError("no")


@pytest.mark.parametrize("value", [*NO_NUMBERS, float("inf"), -float("inf"), 10**400])
def test_what_is_no_finite_number_is_refused(value: object) -> None:
    """Text, truth values, arrays, dates, NaN and infinity; the error is a ValueError and carries what was given."""
    with pytest.raises(InvalidValue, match="margin has to be a finite number") as caught:
        as_number(value, "margin")
    assert isinstance(caught.value, ValueError)
    assert isinstance(caught.value, RlbenchPinError)
    assert (caught.value.what, caught.value.value) == ("margin", value) or value is not caught.value.value


@pytest.mark.parametrize("value", [1, 1.5, np.float32(1.5), np.int8(3), np.float64(2.0), -0.0])
def test_numbers_of_python_and_numpy_become_floats(value: float) -> None:
    """Whatever their width."""
    assert as_number(value, "x") == float(value)
    assert type(as_number(value, "x")) is float


def test_ranges_are_said() -> None:
    """The message has the range, and the bounds belong to it as it says."""
    assert as_number(0.0, "x", least=0.0) == 0.0
    assert as_number(float("inf"), "x", finite=False) == float("inf")
    with pytest.raises(InvalidValue, match=r"x has to be a finite number > 0\. Got 0\."):
        as_number(0, "x", above=0.0)
    with pytest.raises(InvalidValue, match=r">= 1 and <= 2\. Got 3"):
        as_whole(3, "x", least=1, most=2)


@pytest.mark.parametrize("value", [*NO_NUMBERS, 1.5, 1.0, float("inf")])
def test_what_is_no_whole_number_is_refused(value: object) -> None:
    """1.0 is none either: whoever computes a count says how it is rounded."""
    with pytest.raises(InvalidValue, match="whole number"):
        as_whole(value, "count")


@pytest.mark.parametrize("kind", [np.uint8, np.int8, np.int16, np.uint32, np.int64, np.uint64, int])
def test_whole_numbers_of_any_width_do_not_wrap(kind: Callable[[int], object]) -> None:
    """The largest value of each type can be counted on."""
    largest = int(np.iinfo(kind).max) if kind is not int else 10**30  # type: ignore[type-var]
    number = as_whole(kind(largest), "n")
    assert type(number) is int
    assert number + 1 == largest + 1


def test_seeds_are_what_episode_files_hold() -> None:
    """From 0 to 2^63 - 1."""
    assert as_seed(np.uint8(255)) == 255
    assert as_seed(LARGEST_SEED) == 2**63 - 1
    for seed in (-1, 2**63, np.uint64(2**63), True, 1.5, "1", None):
        with pytest.raises(InvalidArgument, match="seed") as caught:
            as_seed(seed, error=InvalidArgument)
        assert isinstance(caught.value, TaskEnvironmentError)


def test_switches_are_truth_values() -> None:
    """0 and 1 stand for them, other numbers and text do not."""
    assert [as_flag(value, "x") for value in (True, np.False_, 0, 1)] == [True, False, False, True]
    for value in ("no", 2, None, 0.0, [], np.array([True])):
        with pytest.raises(InvalidValue, match="x has to be True or False"):
            as_flag(value, "x")


def test_sizes_of_pictures() -> None:
    """A pair, or one number for both sides."""
    assert as_picture_size(64, "size") == (64, 64)
    assert as_picture_size([64, np.int16(32)], "size") == (64, 32)
    assert as_picture_size(np.array([64, 32]), "size") == (64, 32)
    for size in (0, -1, 64.0, True, "64", "ab", (64,), (64, 64, 3), (64, 0), (64, 1.5), None, (64, 10**9), {64, 32}):
        with pytest.raises(InvalidValue, match="size"):
            as_picture_size(size, "size")


def test_intervals_are_in_order() -> None:
    """The lower bound comes first."""
    assert as_interval([0, np.float32(1.0)], "clip") == (0.0, 1.0)
    with pytest.raises(InvalidValue, match="lower bound above"):
        as_interval((1, 0), "clip")
    for value in ((0.0,), "01", None, 1.0, (0.0, float("nan")), (0.0, 1.0, 2.0), (False, True)):
        with pytest.raises(InvalidValue):
            as_interval(value, "clip")


def test_words() -> None:
    """One of a list; the nearest is named."""
    assert as_choice("cpu", "renderer", ("cpu", "egl")) == "cpu"
    with pytest.raises(UnknownName, match="Did you mean 'cpu'"):
        as_choice("cppu", "renderer", ("cpu", "egl"))
    with pytest.raises(UnknownName):
        as_choice(["cpu"], "renderer", ("cpu", "egl"))


def test_any_object_can_be_shown() -> None:
    """Long values are cut, and an object that refuses to be shown is named by its class."""
    with pytest.raises(InvalidValue, match="a Unshowable"):
        as_number(Unshowable(), "x")
    with pytest.raises(InvalidValue) as caught:
        as_number("y" * 10_000, "x")
    assert len(str(caught.value)) < 300
