"""What an instruction asks for: its words, and the colours among them."""

from __future__ import annotations

import re
from dataclasses import dataclass

from rlbench_pin.evaluation.baselines.classical.perception import PALETTE


@dataclass(frozen=True)
class Instruction:
    """One sentence, taken apart."""

    words: tuple[str, ...]
    """In lower case, in their order."""

    @classmethod
    def read(cls, sentence: str) -> Instruction:
        """Take a sentence apart."""
        return cls(tuple(re.findall(r"[a-z0-9]+", sentence.lower())))

    @property
    def colors(self) -> tuple[str, ...]:
        """The colour words, in their order, each once."""
        return tuple(dict.fromkeys(word for word in self.words if word in PALETTE))

    def has(self, phrase: str) -> bool:
        """Say whether a word, or several that follow each other, occurs; `a|b` means either."""
        text = f" {' '.join(self.words)} "
        return any(f" {choice} " in text for choice in phrase.split("|"))

    def one_of(self, words: tuple[str, ...]) -> str | None:
        """Return the first of some words that occurs; None when none does."""
        return next((word for word in self.words if word in words), None)
