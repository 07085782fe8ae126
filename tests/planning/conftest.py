"""What the tests of planning share."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.robot.description import robot_description
from rlbench_pin.robot.model import JointLimits, RobotModel
from tests.worlds_for_tests import Boxes


@pytest.fixture(scope="session")
def model() -> RobotModel:
    """The Panda on its table."""
    return RobotModel(robot_description("panda"))


@pytest.fixture(scope="session")
def limits(model: RobotModel) -> JointLimits:
    """The Panda's limits at the speed of demonstrations."""
    return model.limits.capped(1.0, 4.0)


@pytest.fixture
def boxes(tmp_path: Path) -> Boxes:
    """A maker of small worlds."""
    return Boxes(tmp_path)


@pytest.fixture
def rng() -> np.random.Generator:
    """A generator that starts anew in every test."""
    return np.random.default_rng(0)
