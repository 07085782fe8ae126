"""McNemar's test of paired outcomes, Holm's correction for several tests, and how many episodes a difference needs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rlbench_pin.errors import InvalidValue
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_array, as_number, as_whole

SIGNIFICANT = 0.05
"""A difference whose p-value is below this is called significant."""
_MOST = 10**6


@dataclass(frozen=True)
class PValues:
    """How likely so uneven a split of the pairs that differ would be, were both policies equally good."""

    exact: float
    """Exact binomial, two-sided: at most the level that it promises."""
    mid: float
    """With half of the probability of the observed split itself: nearer to the level, at times a little above it."""


def mcnemar(only_first: int, only_second: int) -> PValues:
    """Test paired outcomes: of the pairs that differ, each is as likely to be won by the one as by the other.

    With n pairs that differ, X ~ Binomial(n, 1/2) and m the smaller count:
    exact = 2 P(X <= m), at most 1; mid = 2 P(X < m) + P(X = m).

    Args:
        only_first: Pairs in which the first alone succeeded.
        only_second: Pairs in which the second alone succeeded.
    """
    first, second = (
        as_whole(value, what, least=0, most=_MOST) for value, what in ((only_first, "only_first"), (only_second, "only_second"))
    )
    probabilities = _binomial(first + second, 0.5)
    low = min(first, second)
    below, here = float(probabilities[:low].sum()), float(probabilities[low])
    return PValues(min(1.0, 2.0 * (below + here)), min(1.0, 2.0 * below + here))


def holm(p_values: Sequence[float]) -> list[float]:
    """Return p-values corrected for being several, in their order: of m, the i-th smallest times m - i + 1, never falling.

    Args:
        p_values: Of the tests; the chance that any of those without a difference is called significant is at most the level.
    """
    values = [as_number(p, "p-value", least=0.0, most=1.0) for p in _flat(p_values)]
    corrected, largest = [0.0] * len(values), 0.0
    for rank, place in enumerate(sorted(range(len(values)), key=values.__getitem__)):
        largest = max(largest, min(1.0, (len(values) - rank) * values[place]))
        corrected[place] = largest
    return corrected


def _flat(p_values: object) -> list[float]:
    array = as_array(p_values, "p_values")
    if array.ndim != 1:
        raise InvalidValue("p_values", p_values, "has to be a list of numbers")
    return [float(p) for p in array]


def pair_shares(first: float, second: float, shared: float) -> tuple[float, float]:
    """Return how often the first alone, and the second alone, succeeds, where a share of the episodes is as hard for both.

    In that share both succeed where a common draw u ~ U(0, 1) is below their rate, so that the worse one succeeds nowhere alone.
    In the rest their outcomes are independent.

    Args:
        first: Success rate of the first.
        second: Success rate of the second.
        shared: The share, 0 to 1.
    """
    p, q, s = (
        as_number(value, what, least=0.0, most=1.0) for value, what in ((first, "first"), (second, "second"), (shared, "shared"))
    )
    return s * max(p - q, 0.0) + (1 - s) * p * (1 - q), s * max(q - p, 0.0) + (1 - s) * q * (1 - p)


def paired_power(first: float, second: float, shared: float, episodes: int, level: float = SIGNIFICANT) -> float:
    """Return how probable it is that the exact test calls a difference significant.

    Args:
        first: Success rate of the first policy.
        second: Success rate of the second.
        shared: Share of the episodes that are as hard for both, as `pair_shares` has it.
        episodes: How many both play.
        level: p-values up to this are called significant.

    Returns:
        Sum over m pairs that differ and all splits of them that are significant.
    """
    only_first, only_second = pair_shares(first, second, shared)
    episodes = as_whole(episodes, "episodes", least=0, most=20_000)
    level = as_number(level, "level", above=0.0, most=1.0)
    differ = only_first + only_second
    if differ == 0.0:
        return 0.0
    total = 0.0
    for m, weight in enumerate(_binomial(episodes, min(1.0, differ))):
        if weight > 1e-12:
            lower = 2.0 * np.cumsum(_binomial(m, 0.5)[: (m + 1) // 2])
            critical = int(np.searchsorted(lower, level, side="right"))  # splits with fewer than this on one side
            chances = _binomial(m, only_second / differ)
            total += weight * float(chances[:critical].sum() + chances[m + 1 - critical :].sum())
    return float(total)


def episodes_needed(first: float, second: float, shared: float, power: float = 0.8) -> int:
    """Return about how many episodes tell two rates apart with a probability of `power`, to about 2 %.

    Args:
        first: Success rate of the first policy.
        second: Success rate of the second, another one.
        shared: Share of the episodes that are as hard for both, as `pair_shares` has it.
        power: How probable it should be.
    """
    power = as_number(power, "power", above=0.0, most=0.999)
    pair_shares(first, second, shared)  # looks at the three
    as_number(abs(first - second), "difference of the rates", least=0.01)
    enough = 5
    while paired_power(first, second, shared, enough) < power:
        enough = round(1.25 * enough)
    episodes = int(enough / 1.25)
    while episodes < enough and paired_power(first, second, shared, episodes) < power:
        episodes = max(episodes + 1, round(1.02 * episodes))
    return min(episodes, enough)


def _binomial(n: int, p: float) -> FloatArray:
    """Return P(X = k), k = 0 ... n, of a binomial distribution, by logarithms of factorials."""
    if p in (0.0, 1.0):
        return np.eye(n + 1)[n if p else 0]
    factorials = np.concatenate([[0.0], np.cumsum(np.log(np.arange(1, n + 1)))])
    k = np.arange(n + 1)
    logs = factorials[n] - factorials[k] - factorials[n - k] + k * np.log(p) + (n - k) * np.log1p(-p)
    return np.asarray(np.exp(logs))
