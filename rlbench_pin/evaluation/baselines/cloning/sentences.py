"""Sentences as vectors, without a learned model: every word and pair of neighbours is hashed to a place and a sign."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence

import numpy as np

from rlbench_pin.spatial import FloatArray

SENTENCE_SIZE = 96
"""Numbers of an encoded sentence."""

_WORD = re.compile(r"[a-z0-9]+")


def encode_sentence(sentence: str, size: int = SENTENCE_SIZE) -> FloatArray:
    """Return a unit vector, shape (size,), that says which words a sentence has; zero for one without words.

    Feature hashing (Weinberger et al. 2009): the hash of a word gives its place and its sign, so that there is no vocabulary, and
    sentences never seen before have vectors, too. Pairs of neighbouring words count half.

    Args:
        sentence: Any text; case and punctuation do not matter.
        size: Length of the vector.
    """
    words = _WORD.findall(sentence.lower())
    vector = np.zeros(size)
    for term, weight in [*((w, 1.0) for w in words), *((f"{a} {b}", 0.5) for a, b in zip(words, words[1:]))]:
        number = int.from_bytes(hashlib.blake2b(term.encode(), digest_size=8).digest(), "little")
        vector[number // 2 % size] += weight if number % 2 else -weight
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0.0 else vector


def nearest_sentence(sentence: str, known: Sequence[str]) -> int:
    """Return the index of the known sentence whose vector is nearest; the first of several."""
    vectors = np.stack([encode_sentence(k) for k in known])
    return int(np.argmax(vectors @ encode_sentence(sentence)))
