"""Frames of Cartesian actions, by either of their known names."""

from __future__ import annotations

from enum import IntEnum

_WORDS = ("world", "end effector")


class RelativeFrame(IntEnum):
    """Frame that a Cartesian action is expressed in; each equals the word that older programs use for it."""

    WORLD = 0
    EE = 1

    def __eq__(self, other: object) -> bool:
        return other == _WORDS[self.value] if isinstance(other, str) else int(self) == other

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __hash__(self) -> int:
        return hash(int(self))
