"""Intervals of rates."""

from __future__ import annotations

import pytest

from rlbench_pin.rates import Rate, wilson


@pytest.mark.parametrize(
    ("successes", "trials", "low", "high"),
    [(95, 100, 0.8882, 0.9785), (100, 100, 0.9630, 1.0), (0, 20, 0.0, 0.1611), (5, 10, 0.2366, 0.7634)],
)
def test_wilson_matches_published_values(successes: int, trials: int, low: float, high: float) -> None:
    """The score interval agrees with the textbook to four digits."""
    assert wilson(successes, trials) == pytest.approx((low, high), abs=1e-4)


def test_nothing_tried_says_nothing() -> None:
    """Without trials any rate is possible."""
    assert wilson(0, 0) == (0.0, 1.0)
    assert Rate(0, 0).value == 0.0


def test_plain_numbers() -> None:
    """A rate writes itself for JSON."""
    assert Rate(1, 2).as_dict() == {"count": 1, "of": 2, "rate": 0.5, "wilson_95": [0.0945, 0.9055]}
