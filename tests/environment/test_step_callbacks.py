"""Functions that are called after every control tick."""

from __future__ import annotations

import numpy as np

from rlbench_pin.environment import (
    Environment,
    JointPositionActionMode,
    RandomizeEvery,
    TaskEnvironment,
    VisualRandomizationConfig,
)
from rlbench_pin.environment.presets import low_dim_config


def test_a_callback_is_called_once_a_tick_however_often_it_is_registered(reach: TaskEnvironment) -> None:
    """Several callbacks stand side by side; one of them, or all, can be removed, and removing twice is no mistake."""
    calls: list[str] = []
    runtime = reach.runtime

    def first() -> None:
        calls.append("first")

    def second() -> None:
        calls.append("second")

    reach.reset(seed=0)
    for callback in (first, second, first):
        runtime.register_step_callback(callback)
    runtime.step()
    assert calls == ["first", "second"]
    for _ in range(2):
        runtime.remove_step_callback(first)
    runtime.step()
    assert calls == ["first", "second", "second"]
    runtime.register_step_callback(None)
    runtime.step()
    assert len(calls) == 3


def test_a_callback_may_remove_itself(reach: TaskEnvironment) -> None:
    """The others of that tick are called all the same."""
    calls: list[str] = []

    def once() -> None:
        calls.append("once")
        reach.runtime.remove_step_callback(once)

    def always() -> None:
        calls.append("always")

    reach.reset(seed=0)
    for callback in (once, always):
        reach.runtime.register_step_callback(callback)
    for _ in range(2):
        reach.runtime.step()
    reach.runtime.register_step_callback(None)
    assert calls == ["once", "always", "always"]


def test_removing_all_leaves_randomization() -> None:
    """What the environment itself does each tick is no callback of a user."""
    every = {"randomize_every": RandomizeEvery.TRANSITION, "visual_randomization_config": VisualRandomizationConfig()}
    with Environment(JointPositionActionMode(), obs_config=low_dim_config(), seed=0, **every) as env:  # type: ignore[arg-type]
        task = env.get_task("reach_target")
        task.reset(seed=0)
        task.runtime.register_step_callback(None)
        task.step(np.append(np.zeros(7), 0.04))
        assert task.get_state().randomization is not None
