"""One environment at a time, kept while the same task is tested."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from rlbench_pin.environment import Discrete, Environment, JointPosition, MoveArmThenGripper, TaskEnvironment
from rlbench_pin.environment.presets import low_dim_config
from rlbench_pin.tasks import task_names


@pytest.fixture(scope="module", params=task_names())
def task_env(request: pytest.FixtureRequest) -> Iterator[TaskEnvironment]:
    """Every task of the registry with absolute joint positions."""
    with Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=low_dim_config(), seed=0) as env:
        yield env.get_task(request.param)
