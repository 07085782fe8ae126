"""How much a check does, and the pieces of work that this makes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from rlbench_pin.checking.records import Part
from rlbench_pin.checking.trials import Item

REPEATS = 4
"""Seeds whose reset and demonstration are done twice, at most."""
_SEEDS_PER_ITEM: dict[Part, int] = {"demos": 5, "unseen": 5, "repeat": 2, "idle": 10, "random": 5, "reach": 50, "key_frames": 5}


@dataclass(frozen=True)
class CheckPlan:
    """How much a check does; the fields are the arguments of `rlbench-pin check` and their defaults."""

    episodes: int = 30
    """Demonstrations of each task."""
    variations: int = 20
    """Variations of a task at most."""
    replays: int = 50
    """Demonstrations that are played again."""
    key_frames: int = 10
    """Demonstrations whose key frames alone are executed."""
    seed: int = 0
    """Of the first episode."""
    unseen: int = 0
    """Further demonstrations on other seeds."""
    unseen_seed: int = 5000
    """First of those seeds."""
    contract: bool = True
    """Whether words, resets, doing nothing, random actions and reach are judged too."""
    contract_seeds: int = 5
    """Episodes that do nothing, and those with random actions."""
    placements: int = 100
    """Layouts in which every waypoint is tried."""
    max_attempts: int = 10
    """Tries for each demonstration."""

    def items(self, task: str, seeds_at_once: int = 50) -> Iterator[Item]:
        """Yield the work on a task.

        Args:
            task: Its name, or the path of its file.
            seeds_at_once: Most seeds of an item; their results come together.
        """
        if self.contract:
            yield Item(task, "words", (0,), self.variations)
        for part, amount in self._amounts().items():
            first = self.unseen_seed if part == "unseen" else self.seed
            replays = 0 if part == "unseen" else self.replays
            step = min(_SEEDS_PER_ITEM[part], seeds_at_once)
            for i in range(first, first + amount, step):
                chosen = tuple(range(i, min(i + step, first + amount)))
                yield Item(task, part, chosen, self.variations, self.max_attempts, first, replays)

    def _amounts(self) -> dict[Part, int]:
        amounts: dict[Part, int] = {"demos": self.episodes, "unseen": self.unseen, "key_frames": self.key_frames}
        if self.contract:
            amounts |= {"repeat": min(REPEATS, self.contract_seeds), "idle": self.contract_seeds, "random": self.contract_seeds}
            amounts |= {"reach": self.placements}
        return amounts
