"""The plan of a check: numbers of trials, and the items of each task. Its imports are fast, because the command line uses it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

Part = Literal["words", "demos", "unseen", "repeat", "noop", "random", "reach", "key_frames", "friction_only"]

REPEATS = 4
"""Maximum number of seeds whose reset and demonstration are done twice."""
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
    """Maximum number of attempts at each demonstration."""
    first_seed: int = 0
    """First seed of the whole check; it has the first of the drawn variations."""
    replays: int = 1_000_000
    """Number of seeds, from the first, whose demonstrations are replayed."""
    robot: str = "panda"
    """Name of the arm, or path of its TOML file."""


@dataclass(frozen=True)
class CheckPlan:
    """Numbers of trials of a check; `rlbench-pin check` has these arguments, with these defaults."""

    episodes: int = 30
    """Number of demonstrations of each task, spread over its variations."""
    variations: int = 20
    """Maximum number of variations of a task."""
    replays: int = 50
    """Number of demonstrations of each task whose recorded actions are replayed, from the first."""
    key_frames: int = 10
    """Number of demonstrations whose key frames alone are executed, with planned motions. The arm stops or the fingers move at a
    key frame."""
    friction_only: int = 0
    """Number of demonstrations in which friction alone holds grasped objects; 0 in a task without graspable objects."""
    seed: int = 0
    """Seed of the first episode; episode i uses seed + i."""
    unseen: int = 0
    """Number of further demonstrations of each task, with other seeds, counted separately."""
    unseen_seed: int = 5000
    """First seed of the demonstrations of `--unseen`."""
    contract: bool = True
    """Also validate instructions, resets, the no-op policy, random actions, and the reach of the arm."""
    contract_seeds: int = 5
    """Number of seeds for the no-op policy, and for random actions."""
    placements: int = 100
    """Number of random placements of the task at which the reach of every waypoint is checked."""
    max_attempts: int = 10
    """Maximum number of attempts for each demonstration."""

    def items(self, task: str, seeds_at_once: int = 50) -> Iterator[Item]:
        """Yield the items of a task.

        Args:
            task: Its name, or the path of its file.
            seeds_at_once: Maximum number of seeds of an item; their results are returned together.
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
