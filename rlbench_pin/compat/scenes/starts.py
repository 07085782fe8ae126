"""The seed of the next episode, drawn from numpy's global generator, where users of these names expect chance."""

from __future__ import annotations

from typing import Any

import numpy as np

from rlbench_pin.observation import Demo

SEEDS = 2**31
"""Seeds are drawn below this."""
_WORD = 32  # [bit]


class Starts:
    """Draws seeds, and knows the seeds of demonstrations again.

    A program may seed the global generator as a demonstration says (`demo.restore_state()`), then reset, and expects the start of
    that demonstration. So a generator that was just seeded with the seed of a remembered demonstration gives its start.
    """

    def __init__(self) -> None:
        self._known: dict[bytes, tuple[int, int]] = {}

    def remember(self, demo: Demo) -> None:
        """Know the seed of a demonstration again; one without a seed is left out."""
        seed = demo.random_seed
        if isinstance(seed, int | np.integer) and seed >= 0:
            words = np.array([int(seed) >> shift & 0xFFFFFFFF for shift in range(0, max(int(seed).bit_length(), 1), _WORD)])
            fresh = np.random.RandomState(int(seed) if len(words) == 1 else words)
            self._known[_fingerprint(fresh.get_state())] = int(seed), demo.attempt

    def draw(self) -> tuple[int, int]:
        """Return the seed of an episode and which try of it."""
        known = self._known.get(_fingerprint(np.random.get_state())) if self._known else None  # noqa: NPY002
        seed = int(np.random.randint(SEEDS))  # noqa: NPY002
        return (seed, 0) if known is None else known


def _fingerprint(state: Any) -> bytes:
    """Return what tells states of a generator apart."""
    keys, position = state[1], int(state[2])
    return position.to_bytes(2, "big") + np.asarray(keys).tobytes()
