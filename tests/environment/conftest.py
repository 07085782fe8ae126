"""Environments shared by the tests of this folder."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from rlbench_pin.environment import Discrete, Environment, JointPosition, MoveArmThenGripper, ObservationConfig, TaskEnvironment


def low_dim() -> ObservationConfig:
    """All low-dimensional data, no pictures."""
    config = ObservationConfig()
    config.set_all_low_dim(True)
    config.set_all_high_dim(False)
    return config


@pytest.fixture(scope="module")
def reach() -> Iterator[TaskEnvironment]:
    """reach_target with absolute joint positions and no pictures."""
    with Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=low_dim(), seed=0) as env:
        yield env.get_task("reach_target")


@pytest.fixture(scope="module")
def lift() -> Iterator[TaskEnvironment]:
    """pick_and_lift with absolute joint positions and no pictures."""
    with Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=low_dim(), seed=0) as env:
        yield env.get_task("pick_and_lift")
