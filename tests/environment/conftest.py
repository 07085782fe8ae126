"""Environments shared by the tests of this folder."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from rlbench_pin.environment import Discrete, Environment, JointPosition, MoveArmThenGripper, TaskEnvironment
from rlbench_pin.environment.presets import low_dim_config


@pytest.fixture(scope="module")
def reach() -> Iterator[TaskEnvironment]:
    """reach_target with absolute joint positions and no images."""
    with Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=low_dim_config(), seed=0) as env:
        yield env.get_task("reach_target")


@pytest.fixture(scope="module")
def lift() -> Iterator[TaskEnvironment]:
    """pick_and_lift with absolute joint positions and no images."""
    with Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=low_dim_config(), seed=0) as env:
        yield env.get_task("pick_and_lift")
