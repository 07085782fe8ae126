"""Recorded actions are played again until the episode ends."""

from __future__ import annotations

from typing import cast

import numpy as np
import pytest

from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.environment.demos import EXTRA_TICKS
from rlbench_pin.environment.replay import reaches_goal, replay_succeeds
from rlbench_pin.errors import DemoError
from rlbench_pin.observation import Demo, Observation


class FakeEnvironment:
    """An episode that ends at a given step."""

    def __init__(self, end: int, reward: float = 1.0) -> None:
        self.end, self.reward = end, reward
        self.actions: list[float] = []

    def step(self, action: np.ndarray) -> tuple[None, float, bool]:
        """Count the action."""
        self.actions.append(float(action[0]))
        ended = len(self.actions) == self.end
        return None, self.reward * ended, ended


def demo_of(*actions: float | None) -> Demo:
    """Return a demo with these actions after its first frame."""
    frames = [Observation(misc={} if a is None else {"joint_position_action": np.array([a])}) for a in actions]
    return Demo([Observation(), *frames])


@pytest.mark.parametrize(("reward", "reached"), [(1.0, True), (0.0, False)])
def test_stepping_stops_where_the_episode_ends(reward: float, reached: bool) -> None:
    """With a reward the goal was reached, without one it was not; no action follows."""
    environment = FakeEnvironment(2, reward)
    assert reaches_goal(cast(TaskEnvironment, environment), np.arange(5.0)[:, None]) is reached
    assert environment.actions == [0.0, 1.0]


def test_the_last_action_is_repeated() -> None:
    """As long as a demonstration waits for success."""
    environment = FakeEnvironment(100)
    assert not replay_succeeds(cast(TaskEnvironment, environment), demo_of(1.0, 2.0))
    assert environment.actions == [1.0, *[2.0] * (1 + EXTRA_TICKS)]


@pytest.mark.parametrize("demo", [demo_of(), demo_of(1.0, None)])
def test_a_demo_without_actions_is_refused(demo: Demo) -> None:
    """Before anything moves."""
    environment = FakeEnvironment(1)
    with pytest.raises(DemoError, match="no `joint_position_action`"):
        replay_succeeds(cast(TaskEnvironment, environment), demo)
    assert environment.actions == []
