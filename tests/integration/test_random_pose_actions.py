"""Random pose actions: every one is carried out or refused for a typed reason, and a refusal leaves the world as it was."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.environment import (
    Discrete,
    EndEffectorPoseViaPlanning,
    Environment,
    MoveArmThenGripper,
    ObservationConfig,
    TaskEnvironment,
)
from rlbench_pin.environment.actions import pose
from rlbench_pin.errors import InvalidActionError, PlanningError


def world_bytes(task: TaskEnvironment) -> bytes:
    """Everything that the world remembers, but for the engine's own file."""
    arrays = task.world.arrays()
    return b"".join(arrays[name].tobytes() for name in sorted(arrays) if name != "physics")


def act(count: int, monkeypatch: pytest.MonkeyPatch, every: int) -> dict[str, int]:
    """Draw actions in and around the workspace; only each `every`-th that can be planned is really carried out: it takes long."""
    config = ObservationConfig()
    config.set_all_high_dim(False)
    outcomes: dict[str, int] = {}
    follow = pose.follow
    rng = np.random.default_rng(0)
    with Environment(
        MoveArmThenGripper(EndEffectorPoseViaPlanning(collision_checking=True), Discrete()), obs_config=config
    ) as env:
        task = env.get_task("stack_blocks")
        task.reset(seed=0)
        for _ in range(count):
            really = outcomes.get("done", 0) % every == 0
            monkeypatch.setattr(pose, "follow", follow if really else lambda *a, **k: None)
            quaternion = rng.normal(size=4)
            place = rng.uniform([-0.4, -0.7, 0.7], [0.85, 0.7, 1.8])
            action = np.concatenate([place, quaternion / np.linalg.norm(quaternion), [1.0]])
            before = world_bytes(task)
            try:
                task.step(action)
                name = "done"
            except InvalidActionError as error:
                assert world_bytes(task) == before
                cause = error.__cause__
                assert cause is None or isinstance(cause, PlanningError)
                name = cause.reason if isinstance(cause, PlanningError) else "outside"
            outcomes[name] = outcomes.get(name, 0) + 1
    return outcomes


def test_three_hundred_random_actions(monkeypatch: pytest.MonkeyPatch) -> None:
    """Some are carried out, most are refused; nothing else happens."""
    outcomes = act(300, monkeypatch, every=20)
    assert {"done", "outside", "unreachable"} <= set(outcomes)


@pytest.mark.slow
def test_ten_thousand_random_actions(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same, long enough to meet rare reasons."""
    assert sum(act(10_000, monkeypatch, every=100).values()) == 10_000
