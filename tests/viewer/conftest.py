"""Tasks shared by the tests of this folder."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.environment.presets import low_dim_config, make_environment


@pytest.fixture(scope="package")
def reach() -> Iterator[TaskEnvironment]:
    """reach_target without images."""
    with make_environment(low_dim_config()) as environment:
        yield environment.get_task("reach_target")
