"""The plan of a check: numbers of trials, and the items of each task. It imports nothing heavy: the command line uses it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

Part = Literal["words", "demos", "unseen", "repeat", "noop", "random", "reach", "key_frames", "friction_only"]

REPEATS = 4
"""Seeds whose reset and demonstration are done twice, at most."""
_SEEDS_PER_ITEM: dict[Part, int] = {
    "demos": 5,
    "unseen": 5,
    "repeat": 2,
    "noop": 10,
    "random": 5,
    "reach": 50,
    "key_frames": 5,
    "friction_only": 5,
}


@dataclass(frozen=True)
class Item:
    """An item of work: some seeds of one part of the check of one task."""

    task: str
    """Name, or path of a task file."""
    part: Part
    seeds: tuple[int, ...]
    """Seeds of the episodes; not used for `words`, which has one trial for each variation."""
    max_variations: int
    """Maximum number of variations to draw."""
    max_attempts: int = 10
    """Attempts at each demonstration."""
    first_seed: int = 0
    """First seed of the whole check; it has the first of the variations drawn."""
    replays: int = 1_000_000
    """Seeds, from the first on, whose demonstrations are replayed."""
    robot: str = "panda"
    """Name of the arm, or path of its TOML file."""


@dataclass(frozen=True)
class CheckPlan:
    """Numbers of trials of a check; `rlbench-pin check` has these arguments, with these defaults."""

    episodes: int = 30
    """Demonstrations of each task, spread over its variations."""
    variations: int = 20
    """Maximum number of variations of a task."""
    replays: int = 50
    """Number of demonstrations whose recorded actions are replayed, the first ones of a task."""
    key_frames: int = 10
    """Number of demonstrations whose key frames alone (where the arm rests or the fingers move) are executed through planning."""
    friction_only: int = 0
    """Number of demonstrations in which friction alone holds what is grasped; none in a task without graspable objects."""
    seed: int = 0
    """Seed of the first episode; episode i uses seed + i."""
    unseen: int = 0
    """Further demonstrations of each task on other seeds, counted separately."""
    unseen_seed: int = 5000
    """First of those seeds."""
    contract: bool = True
    """Also validate instructions, resets, the no-op policy, random actions, and what the arm reaches."""
    contract_seeds: int = 5
    """Number of seeds for the no-op policy, and for random actions."""
    placements: int = 100
    """Number of random places of the task at which every waypoint is tried."""
    max_attempts: int = 10
    """Attempts for each demonstration."""

    def items(self, task: str, seeds_at_once: int = 50) -> Iterator[Item]:
        """Yield the items of a task.

        Args:
            task: Its name, or the path of its file.
            seeds_at_once: Maximum number of seeds of an item; their results come together.
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
        amounts["friction_only"] = self.friction_only
        if self.contract:
            amounts |= {"repeat": min(REPEATS, self.contract_seeds), "noop": self.contract_seeds, "random": self.contract_seeds}
            amounts |= {"reach": self.placements}
        return amounts
