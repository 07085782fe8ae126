"""What the tests of control share."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.robot.description import robot_description
from rlbench_pin.robot.model import RobotModel


@pytest.fixture(scope="session")
def model() -> RobotModel:
    """The Panda on its table."""
    return RobotModel(robot_description("panda"))


@pytest.fixture
def rng() -> np.random.Generator:
    """A generator that every test starts afresh."""
    return np.random.default_rng(0)
