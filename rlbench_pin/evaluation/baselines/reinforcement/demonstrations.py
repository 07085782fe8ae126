"""Demonstrations of the planner as experience: played again with the actions of the learner, tick by tick."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from rlbench_pin.errors import DemoError
from rlbench_pin.evaluation.baselines.reinforcement.features import TICKS, as_unit, features
from rlbench_pin.evaluation.baselines.reinforcement.world import LearningEnv
from rlbench_pin.observation import Demo

FIRST_SEED = 2**32
"""Seed of the first demonstration; training draws below 2^31."""
MOST_TRIES = 3
"""Demonstrations that are tried for each that is wanted."""
NOISE = 0.15
"""Spread of what is added to the actions of the arm, so that there is experience beside the path as well."""
TIMES = 2
"""How often each demonstration is followed."""


@dataclass(frozen=True)
class Experience:
    """Transitions; row i of each array belongs together."""

    seen: np.ndarray
    """Features before, float32 (n, m)."""
    then: np.ndarray
    """Features after, float32 (n, m)."""
    actions: np.ndarray
    """Between -1 and 1, float32 (n, k)."""
    rewards: np.ndarray
    """float32 (n,)."""
    ends: np.ndarray
    """Whether the episode ended, float32 (n,)."""

    @classmethod
    def joined(cls, parts: Sequence[Experience]) -> Experience:
        """Return several as one."""
        names = ("seen", "then", "actions", "rewards", "ends")
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))

    def __len__(self) -> int:
        """Return how many transitions there are."""
        return len(self.seen)


def gather(env: LearningEnv, count: int, on_demo: Callable[[int, int], None] = lambda done, wanted: None) -> Experience:
    """Plan demonstrations, variations in turn, and return the transitions of those that succeed with the learner's actions.

    Args:
        env: The task.
        count: How many demonstrations.
        on_demo: Called with how many there are, and how many are wanted.

    Raises:
        DemoError: Too few succeed.
    """
    found: list[Experience] = []
    for index in range(MOST_TRIES * count):
        outcome = env.task.try_demo(seed=FIRST_SEED + index, variation=index % env.task.variation_count())
        if outcome.demo is None:
            continue
        rng = np.random.default_rng(FIRST_SEED + index)
        played = [p for p in (follow(env, outcome.demo, rng) for _ in range(TIMES)) if p is not None]
        if played:
            found.append(Experience.joined(played))
            on_demo(len(found), count)
        if len(found) == count:
            return Experience.joined(found)
    raise DemoError(
        f"{len(found)} of {MOST_TRIES * count} demonstrations succeed with the actions of the learner; {count} are wanted."
        " Longer episodes may help: --episode-steps."
    )


def follow(env: LearningEnv, demo: Demo, rng: np.random.Generator) -> Experience | None:
    """Follow joints and hand of a demonstration, with noise; None where that does not succeed within an episode.

    The noise is made good by the decisions after it, and means nothing on average: the mean action is the right one.
    """
    seen, rows = env.reset_to(demo), []
    for index in range(TICKS, 2 * len(demo), TICKS):
        goal = demo[min(index, len(demo) - 1)]
        joints, wanted = np.asarray(seen.joint_positions), np.asarray(goal.joint_positions)
        clean = as_unit(joints, wanted, (goal.gripper_open or 0.0) > 0.5)
        noise = np.append(rng.normal(scale=NOISE, size=len(clean) - 1), 0.0)
        action = np.clip(clean + noise, -1.0, 1.0).astype(np.float32)
        before = features(seen)
        after, reward, over, cut, info = env.step(action)
        rows.append((before, after, action, np.float32(reward), np.float32(over)))
        seen = info["observation"]
        if over or cut:
            return Experience(*(np.array(column, np.float32) for column in zip(*rows))) if info["is_success"] else None
    return None
