"""What the tests of the robot share."""

from __future__ import annotations

from pathlib import Path

import pytest

from rlbench_pin.robot.description import robot_description
from rlbench_pin.robot.model import RobotModel
from tests.worlds_for_tests import Boxes


@pytest.fixture(scope="session")
def model() -> RobotModel:
    """The Panda on its table."""
    return RobotModel(robot_description("panda"))


@pytest.fixture
def boxes(tmp_path: Path) -> Boxes:
    """A maker of small worlds."""
    return Boxes(tmp_path)
