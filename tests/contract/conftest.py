"""One environment at a time, kept while the same task is judged."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from rlbench_pin.environment import Discrete, Environment, JointPosition, MoveArmThenGripper, ObservationConfig, TaskEnvironment
from rlbench_pin.tasks import task_names


def low_dim() -> ObservationConfig:
    """All low-dimensional data, no pictures."""
    config = ObservationConfig()
    config.set_all_low_dim(True)
    config.set_all_high_dim(False)
    return config


@pytest.fixture(scope="module", params=task_names())
def task_env(request: pytest.FixtureRequest) -> Iterator[TaskEnvironment]:
    """Every task of the registry with absolute joint positions."""
    with Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=low_dim(), seed=0) as env:
        yield env.get_task(request.param)
