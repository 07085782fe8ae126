"""Success rates with confidence intervals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Rate:
    """A rate as a number of successes in a number of trials, with a 95 % confidence interval."""

    count: int
    of: int

    @property
    def value(self) -> float:
        """The fraction of successes; 0 without trials."""
        return self.count / self.of if self.of else 0.0

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson score interval at 95 %."""
        return wilson(self.count, self.of)

    def as_dict(self) -> dict[str, float | int | list[float]]:
        """Return plain numbers for JSON."""
        return {
            "count": self.count,
            "of": self.of,
            "rate": round(self.value, 4),
            "wilson_95": [round(v, 4) for v in self.interval],
        }


def wilson(successes: int, trials: int, z: float = 1.959964) -> tuple[float, float]:
    """Return the Wilson score interval of a rate.

    centre = (p + z^2 / 2n) / (1 + z^2 / n), half width = z / (1 + z^2 / n) * sqrt(p (1 - p) / n + z^2 / 4n^2)
    """
    if trials == 0:
        return 0.0, 1.0
    p, n = successes / trials, float(trials)
    scale = 1.0 + z**2 / n
    centre = (p + z**2 / (2.0 * n)) / scale
    half = z / scale * float(np.sqrt(p * (1.0 - p) / n + z**2 / (4.0 * n**2)))
    low = 0.0 if successes == 0 else centre - half
    high = 1.0 if successes == trials else centre + half
    return max(0.0, low), min(1.0, high)
